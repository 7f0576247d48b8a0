// Plays tones with a few WebAudio voices.

import { placeOf } from "../../model/worlds.js";
import { sides } from "../../paint/geometry.js";
import { HOME, TIMBRES } from "./timbres.js";
import { chimeOf, chosen, toneOf, withOvertones } from "./tones.js";

/** @import { QueuedImpact } from "../../model/table/impact-queue.js" */
/** @import { Store } from "../store.js" */
/** @import { Tone } from "./tones.js" */

const VOICES = 16;
const STALE = 0.1; // s: older impacts are not played
const MASTER = 0.8; // gain into the limiter at full volume

/** The sound of a table's board. */
export class Sound {
  playing = 0;
  on = false;
  /** @type {{left: number, right: number} | null} of the board, m */
  #sides = null;
  #timbre = HOME;

  /** @param {AudioContext} context @param {Store} news of the table */
  constructor(context, news) {
    this.context = context;
    this.master = context.createGain();
    this.master.connect(context.createDynamicsCompressor()).connect(context.destination);
    news.on("table", ({ hello: { board } }) => {
      this.#sides = sides(board);
      this.#timbre = TIMBRES[placeOf(board.name) ?? ""] ?? HOME;
    });
  }

  /** @param {number} volume 0 … 1; the gain is its square, which sounds about linear */
  set volume(volume) {
    this.master.gain.value = MASTER * volume ** 2;
  }

  /**
   * @param {QueuedImpact[]} impacts that became due with this frame
   * @param {number} t table time of the frame, s
   */
  hear(impacts, t) {
    const across = this.#sides;
    if (!this.#audible || !across) return;
    const tones = [];
    for (const impact of impacts) {
      const tone = t - impact.t < STALE ? toneOf(impact, across, this.#timbre) : null;
      if (tone) tones.push(...withOvertones(tone, this.#timbre));
    }
    for (const tone of chosen(tones, VOICES - this.playing)) this.#strike(tone, 0);
  }

  /** @param {number} score the multiplier of our ball @param {number} place 0 … 1 from left to right */
  chime(score, place) {
    if (!this.#audible || !this.#sides) return;
    chosen(chimeOf(score, place, this.#timbre), VOICES - this.playing).forEach((tone, i) => {
      this.#strike(tone, 0.07 * i);
    });
  }

  get #audible() {
    return this.on && document.visibilityState !== "hidden";
  }

  /** Plays one struck tone, which decays by itself. @param {Tone} tone @param {number} later s */
  #strike({ frequency, gain, decay, pan, wave, bend }, later) {
    this.playing += 1;
    const { context } = this;
    const start = context.currentTime + later;
    const voice = context.createOscillator();
    const envelope = context.createGain();
    const place = context.createStereoPanner();
    voice.type = wave;
    voice.frequency.setValueAtTime(bend * frequency, start);
    voice.frequency.exponentialRampToValueAtTime(frequency, start + 0.012);
    envelope.gain.setValueAtTime(0, start);
    envelope.gain.linearRampToValueAtTime(gain, start + 0.002);
    envelope.gain.exponentialRampToValueAtTime(gain / 1000, start + decay);
    place.pan.value = pan;
    voice.connect(envelope).connect(place).connect(this.master);
    voice.onended = () => {
      place.disconnect();
      this.playing -= 1;
    };
    voice.start(start);
    voice.stop(start + decay);
  }
}
