// Lets balls go: one at once, several one after another, or on and on at a rate.

import { Pacer } from "./pacer.js";

/** @import { Ask } from "./controls.js" */

const SHOWER_RATE = 12; // a second: several balls of one push, told apart and within any limit

/** @typedef {{pacer: Pacer, ask: () => Ask}} Shower */

/**
 * What ends an auto-drop before its count: so much won or lost on what has landed since it began.
 * @typedef {{win: number, loss: number}} Limits Infinity for never
 *
 * @typedef {object} DropperListener
 * @property {() => boolean} hasRoom whether the table takes another ball now
 * @property {(ask: Ask) => boolean} onDrop false when it could not even be asked for
 * @property {(running: boolean, left: number) => void} onAuto
 */

/** Paces drops; a hidden tab's slow timers make it slower, never make it catch up. */
export class Dropper {
  /** @type {Shower | null} */
  #auto = null;
  /** Won on what has landed since auto-drop began. */
  #won = 0;
  /** @type {Limits} */
  #limits = { win: Number.POSITIVE_INFINITY, loss: Number.POSITIVE_INFINITY };
  /** @type {Shower[]} */
  #showers = [];
  #timer = 0;

  /** @param {DropperListener} listener */
  constructor(listener) {
    this.listener = listener;
  }

  get running() {
    return this.#auto !== null;
  }

  /** @param {number} count @param {() => Ask} ask makes what each of them is */
  shower(count, ask) {
    this.#showers.push({ pacer: new Pacer(SHOWER_RATE, count, performance.now()), ask });
    this.#pump();
  }

  /** @param {number} rate a second @param {number} count @param {() => Ask} ask @param {Limits} limits */
  start(rate, count, ask, limits) {
    this.#won = 0;
    this.#limits = limits;
    this.#auto = { pacer: new Pacer(rate, count, performance.now()), ask };
    this.#pump();
  }

  /**
   * A ball of ours has landed.
   * @param {{stake?: number, score: number, practice?: boolean}} played
   * @returns {number | null} what was won (lost: below 0), where that has stopped auto-drop
   */
  landed({ stake = 1, score, practice = false }) {
    if (!this.#auto || practice) return null;
    this.#won += stake * (score - 1);
    if (this.#won < this.#limits.win && this.#won > -this.#limits.loss) return null;
    this.stop();
    return this.#won;
  }

  stop() {
    if (!this.#auto) return;
    this.#auto = null;
    this.listener.onAuto(false, 0);
  }

  /** All that was still to come is off. */
  clear() {
    this.#showers.length = 0;
    this.stop();
  }

  #pump() {
    clearTimeout(this.#timer);
    const now = performance.now();
    for (const shower of this.#showers) this.#give(shower, now);
    this.#showers = this.#showers.filter(({ pacer }) => !pacer.done);
    if (this.#auto) {
      this.#give(this.#auto, now);
      if (this.#auto?.pacer.done) this.stop();
      else if (this.#auto) this.listener.onAuto(true, this.#auto.pacer.left);
    }
    const waiting = this.#auto ? [...this.#showers, this.#auto] : this.#showers;
    if (waiting.length === 0) return;
    const wait = Math.min(...waiting.map(({ pacer }) => pacer.wait(now)));
    this.#timer = setTimeout(() => this.#pump(), Math.max(4, wait));
  }

  /** @param {Shower} shower @param {number} now */
  #give({ pacer, ask }, now) {
    if (!pacer.take(now)) return;
    if (!this.listener.hasRoom()) pacer.postpone(now);
    else if (!this.listener.onDrop(ask())) this.clear();
  }
}
