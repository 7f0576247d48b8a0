// Impacts that are known before the screen shows them, and pegs that still glow. Pure.

/** @import { Flash } from "../scene.js" */
/** @import { Peg } from "../board.js" */

const PEG = 0;
const WAITING = 2048; // several times the impacts of a full table in a tenth of a second
const FLASH_SECONDS = 0.35;
const LOUD = 3; // m/s: an impact of this speed flashes at full strength

/** @typedef {{t: number, x: number, y: number, kind: number, index: number, speed: number}} QueuedImpact */

/** @typedef {Flash & {since: number}} LitFlash since: table time of the impact, s */

/** A ring buffer of coming impacts, and one flash for each peg, so that memory is bounded. */
export class ImpactQueue {
  /** @type {QueuedImpact[]} */
  #ring = [];
  #first = 0;
  #count = 0;
  /** @type {LitFlash[]} */
  #lit = [];

  /** @param {Peg[]} pegs */
  constructor(pegs) {
    this.pegs = pegs;
    this.flashes = pegs.map(({ x, y, radius }) => (
      { x, y, radius, age: 1, strength: 0, since: Number.NEGATIVE_INFINITY }
    ));
  }

  get busy() {
    return this.#count > 0 || this.#lit.length > 0;
  }

  /** @param {number} t s @param {Omit<QueuedImpact, "t">} impact replaces the oldest one if the queue is full */
  add(t, { x, y, kind, index, speed }) {
    if (this.#count === WAITING) this.#drop();
    const at = (this.#first + this.#count) % WAITING;
    const impact = (this.#ring[at] ??= { t: 0, x: 0, y: 0, kind: 0, index: 0, speed: 0 });
    impact.t = t;
    impact.x = x;
    impact.y = y;
    impact.kind = kind;
    impact.index = index;
    impact.speed = speed;
    this.#count += 1;
  }

  /**
   * Lights the pegs whose impacts are due and lets the others fade.
   * @param {number} t s
   * @param {QueuedImpact[]} heard is filled with the impacts that became due, for the sound
   */
  advance(t, heard) {
    heard.length = 0;
    while (this.#count > 0 && this.#ring[this.#first].t <= t) {
      const impact = this.#ring[this.#first];
      heard.push(impact);
      if (impact.kind === PEG) this.#light(impact);
      this.#drop();
    }
    let kept = 0;
    for (const flash of this.#lit) {
      flash.age = (t - flash.since) / FLASH_SECONDS;
      if (flash.age >= 0 && flash.age < 1) this.#lit[kept++] = flash;
    }
    this.#lit.length = kept;
  }

  /** @returns {Flash[]} */
  get lit() {
    return this.#lit;
  }

  /** @param {QueuedImpact} impact */
  #light({ t, index, speed }) {
    const flash = this.flashes[index];
    if (!flash) return;
    if (!this.#lit.includes(flash)) this.#lit.push(flash);
    flash.since = t;
    flash.strength = Math.min(1, speed / LOUD);
  }

  #drop() {
    this.#first = (this.#first + 1) % WAITING;
    this.#count -= 1;
  }
}
