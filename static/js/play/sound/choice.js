// Whether a player wants to hear the table, and how loud: offered at the first drop, kept for all days after.

import { byId } from "../../util/dom.js";

/** @import { Sound } from "./sound.js" */

const KEY = "plinko.sound.1";
const VOLUME = 0.6; // until the player says otherwise
const GESTURES = ["pointerdown", "keydown"];

/** @typedef {{on: boolean, volume: number}} Kept */

/** The switch in the head, the volume in the settings, and the offer over the board. */
export class SoundChoice {
  /** @type {Kept | null} null until the player has said */
  #kept;

  /** @param {Sound} sound @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(sound, storage) {
    this.sound = sound;
    this.storage = storage;
    this.#kept = read(storage.getItem(KEY));
    this.button = byId("sound");
    this.offerBox = byId("offer");
    this.volumes = ["volume", "offer-volume"].map((id) => byId(id, HTMLInputElement));
    this.button.addEventListener("click", () => this.#answer(!this.#on));
    byId("offer-yes").addEventListener("click", () => this.#answer(true));
    byId("offer-no").addEventListener("click", () => this.#answer(false));
    for (const field of this.volumes) {
      field.addEventListener("input", () => this.#setVolume(Number(field.value) / 100));
    }
    this.#show();
    if (this.#on) this.#soundAtFirstGesture();
  }

  /** A ball falls for the first time: would the player like to hear it? */
  offer() {
    if (!this.#kept) this.offerBox.hidden = false;
  }

  get #on() {
    return this.#kept?.on ?? false;
  }

  get #volume() {
    return this.#kept?.volume ?? Number(this.volumes[0].value) / 100;
  }

  /** Browsers let a page sound only once somebody has touched it. */
  #soundAtFirstGesture() {
    const begin = () => {
      for (const gesture of GESTURES) document.removeEventListener(gesture, begin, true);
      if (this.#on) this.sound.switch(true);
    };
    for (const gesture of GESTURES) document.addEventListener(gesture, begin, true);
  }

  /** @param {boolean} on */
  #answer(on) {
    this.#keep({ on, volume: this.#volume });
    this.offerBox.hidden = true;
    this.sound.switch(on);
  }

  /** @param {number} volume 0 … 1 */
  #setVolume(volume) {
    // In the offer nothing is decided yet.
    if (this.#kept) this.#keep({ ...this.#kept, volume });
    this.#show(volume);
  }

  /** @param {Kept} kept */
  #keep(kept) {
    this.#kept = kept;
    this.storage.setItem(KEY, JSON.stringify(kept));
    this.#show();
  }

  #show(volume = this.#kept?.volume ?? VOLUME) {
    this.sound.volume = volume;
    for (const field of this.volumes) field.value = String(Math.round(100 * volume));
    this.button.setAttribute("aria-pressed", String(this.#on));
  }
}

/** @param {string | null} text @returns {Kept | null} */
function read(text) {
  return text === null ? null : JSON.parse(text);
}
