// The player's choice of sound and volume: asked at the first drop of a visit, and stored for all tabs. The sound itself
// is loaded once it is switched on.

import { byId, onClick } from "../../util/dom.js";
import { isRecord, readStored } from "../../util/stored.js";

/** @import { Game } from "../game.js" */
/** @import { Sound } from "./sound.js" */

const KEY = "plinko.sound.1";
const ASKED_KEY = "plinko.sound-asked.1"; // when, ms
const VISIT_MS = 12 * 3600 * 1000; // after which an unanswered question is asked again
const VOLUME = 0.6; // until the player chooses one
const GESTURES = ["pointerdown", "keydown"];

/** @param {unknown} value @returns {value is {on: boolean, volume: number}} */
function isAnswer(value) {
  return isRecord(value) && typeof value.on === "boolean" && typeof value.volume === "number" && value.volume >= 0
    && value.volume <= 1;
}

/**
 * The switch in the header, the volume in the settings, and the offer on the board.
 * @param {Game} game
 * @returns {{ask: () => void, sound: () => Sound | null}} ask: to be called when a ball falls: asks the player, unless
 *   already answered; sound: null until it has been switched on
 */
export function offerSound(game) {
  const { storage } = game;
  /** Made by the gesture that switches sound on, as browsers demand. @type {AudioContext | null} */
  let context = null;
  /** @type {Sound | null} */
  let sound = null;
  /** Null until the player has answered. */
  let kept = readStored(storage, KEY, isAnswer);
  const volumes = ["volume", "offer-volume"].map((id) => byId(id, HTMLInputElement));

  /** @param {number} volume 0 … 1 */
  const show = (volume) => {
    if (sound) sound.volume = volume;
    for (const field of volumes) field.value = String(Math.round(100 * volume));
    byId("sound").setAttribute("aria-pressed", String(kept?.on ?? false));
  };
  /** To be called from a click or a key: browsers allow sound only then. @param {boolean} on */
  const turn = async (on) => {
    if (sound) sound.on = on;
    if (!on) {
      await context?.suspend();
      return;
    }
    context ??= new AudioContext({ latencyHint: "interactive" });
    void context.resume();
    const { Sound } = await import("./sound.js");
    sound ??= new Sound(context, game);
    sound.on = kept?.on ?? false; // the player may have answered again
    sound.volume = kept?.volume ?? VOLUME;
  };
  /** @param {boolean} on @param {number} volume */
  const keep = (on, volume) => {
    kept = { on, volume };
    storage.setItem(KEY, JSON.stringify(kept));
    show(volume);
  };
  /** @param {boolean} on @param {number} [volume] */
  const answer = (on, volume = kept?.volume ?? Number(volumes[0].value) / 100) => {
    keep(on, volume);
    byId("offer").hidden = true;
    void turn(on);
  };
  onClick("sound", () => answer(!kept?.on));
  onClick("offer-yes", () => answer(true));
  onClick("offer-no", () => answer(false));
  for (const field of volumes) {
    field.addEventListener("input", () => {
      const volume = Number(field.value) / 100;
      if (kept) keep(kept.on, volume);
      else show(volume); // the offer is not answered yet
    });
  }
  // Browsers allow sound only after a gesture of the user.
  const begin = () => {
    for (const gesture of GESTURES) document.removeEventListener(gesture, begin, true);
    if (kept?.on) void turn(true);
  };
  if (kept?.on) for (const gesture of GESTURES) document.addEventListener(gesture, begin, true);
  window.addEventListener("storage", ({ key }) => { // another tab has the answer
    const given = key === KEY ? readStored(storage, KEY, isAnswer) : null;
    if (given) answer(given.on, given.volume);
  });
  show(kept?.volume ?? VOLUME);
  const ask = () => {
    if (kept || Date.now() - Number(storage.getItem(ASKED_KEY)) < VISIT_MS) return;
    storage.setItem(ASKED_KEY, String(Date.now()));
    byId("offer").hidden = false;
  };
  return { ask, sound: () => sound };
}
