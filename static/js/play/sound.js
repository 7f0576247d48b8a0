// Plays tones: a few voices of WebAudio, made only once sound was asked for.

import { sides } from "../paint/geometry.js";
import { chimeOf, chosen, toneOf } from "./tones.js";

export const VOICES = 16;
const STALE = 0.1; // s: what is longer over than this is not heard any more
const MASTER = 0.5;

/** Sound of a board. Silent, and without an AudioContext, until it is switched on. */
export class Sound {
  playing = 0;
  #on = false;

  get on() {
    return this.#on;
  }

  /** @param {boolean} on from a click or a key: browsers allow sound only then */
  async switch(on) {
    this.#on = on;
    if (!on) {
      await this.context?.suspend();
      return;
    }
    this.context ??= new AudioContext({ latencyHint: "interactive" });
    this.master ??= this.#makeMaster();
    await this.context.resume();
  }

  /** @param {any} board */
  setBoard(board) {
    this.sides = sides(board);
  }

  /**
   * @param {import("../model/table/impact-queue.js").Impact[]} impacts that became due with this picture
   * @param {number} t table time of the picture, s
   */
  hear(impacts, t) {
    if (!this.#ready) return;
    const tones = [];
    for (const impact of impacts) {
      const tone = t - impact.t < STALE ? toneOf(impact, this.sides) : null;
      if (tone) tones.push(tone);
    }
    for (const tone of chosen(tones, VOICES - this.playing)) this.#strike(tone, 0);
  }

  /** @param {number} score what a ball of ours was paid @param {number} place 0 … 1 across */
  chime(score, place) {
    if (!this.#ready) return;
    chosen(chimeOf(score, place), VOICES - this.playing).forEach((tone, i) => {
      this.#strike(tone, 0.07 * i);
    });
  }

  get #ready() {
    return this.#on && this.sides && document.visibilityState !== "hidden";
  }

  #makeMaster() {
    const limiter = this.context.createDynamicsCompressor();
    const volume = this.context.createGain();
    volume.gain.value = MASTER;
    volume.connect(limiter).connect(this.context.destination);
    return volume;
  }

  #strike({ frequency, gain, decay, pan }, later) {
    strike(this.context, this.master, { frequency, gain, decay, pan }, later, () => {
      this.playing -= 1;
    });
    this.playing += 1;
  }
}

/**
 * One struck tone with its overtone, fading by itself.
 * @param {BaseAudioContext} context
 * @param {AudioNode} into
 * @param {import("./tones.js").Tone} tone
 * @param {number} later s
 * @param {() => void} onEnd
 */
export function strike(context, into, { frequency, gain, decay, pan }, later, onEnd) {
  const start = context.currentTime + later;
  const voice = context.createOscillator();
  const envelope = context.createGain();
  const place = context.createStereoPanner();
  voice.type = "triangle";
  voice.frequency.setValueAtTime(1.5 * frequency, start);
  voice.frequency.exponentialRampToValueAtTime(frequency, start + 0.012);
  envelope.gain.setValueAtTime(0, start);
  envelope.gain.linearRampToValueAtTime(gain, start + 0.002);
  envelope.gain.exponentialRampToValueAtTime(gain / 1000, start + decay);
  place.pan.value = pan;
  voice.connect(envelope).connect(place).connect(into);
  voice.onended = () => {
    place.disconnect();
    onEnd();
  };
  voice.start(start);
  voice.stop(start + decay);
}
