// Impacts that are known before the screen shows them, and pegs that still glow. Pure.

/** @import { Flash } from "../scene.js" */
/** @import { Peg } from "../board.js" */

const PEG = 0;
const WAITING = 2048; // several times the impacts of a full table in a tenth of a second
const FLASH_SECONDS = 0.35;
const LOUD = 3; // m/s: an impact of this speed flashes at full strength

/** @typedef {{t: number, x: number, y: number, kind: number, index: number, speed: number}} QueuedImpact */

/** @typedef {Flash & {since: number}} LitFlash since: table time of the impact, s */

/** Coming impacts, and one flash for each peg, so that memory is bounded. */
export class ImpactQueue {
  /** @type {QueuedImpact[]} */
  #waiting = [];
  /** By peg. @type {Map<number, LitFlash>} */
  #lit = new Map();

  /** @param {Peg[]} pegs */
  constructor(pegs) {
    this.pegs = pegs;
  }

  get busy() {
    return this.#waiting.length > 0 || this.#lit.size > 0;
  }

  /** @param {number} t s @param {Omit<QueuedImpact, "t">} impact replaces the oldest one if the queue is full */
  add(t, { x, y, kind, index, speed }) {
    this.#waiting.push({ t, x, y, kind, index, speed });
    if (this.#waiting.length > WAITING) this.#waiting.shift();
  }

  /**
   * Lights the pegs whose impacts are due and lets the others fade.
   * @param {number} t s
   * @returns {QueuedImpact[]} the impacts that became due, for the sound
   */
  advance(t) {
    const due = this.#waiting.filter((impact) => impact.t <= t);
    if (due.length > 0) this.#waiting = this.#waiting.filter((impact) => impact.t > t);
    for (const { t: since, kind, index, speed } of due) {
      const peg = kind === PEG ? this.pegs[index] : undefined;
      if (peg) this.#lit.set(index, { ...peg, since, age: 0, strength: Math.min(1, speed / LOUD) });
    }
    for (const [peg, flash] of this.#lit) {
      flash.age = (t - flash.since) / FLASH_SECONDS;
      if (!(flash.age >= 0 && flash.age < 1)) this.#lit.delete(peg);
    }
    return due;
  }

  /** @returns {Flash[]} */
  get lit() {
    return [...this.#lit.values()];
  }
}
