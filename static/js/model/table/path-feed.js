// Turns the path of one ball, known from its start to its end, into keyframes as time passes. Pure.

import { normalAt } from "../normal.js";
import { LANDING, PEG, WALL } from "../motion/kinds.js";

/** @import { Board } from "../board.js" */
/** @import { State } from "../motion/flight.js" */
/** @import { ImpactRow } from "../motion/drop.js" */
/** @import { Path } from "../motion/path.js" */

/**
 * @typedef {object} Solved a drop that this page computed; times in s since the start
 * @property {number} duration s
 * @property {ImpactRow[]} impacts
 * @property {(times: number[]) => State[]} states
 * @property {() => State[]} before right before each impact
 * @property {number} xStart m
 * @property {number} xEnd m
 * @property {number | null} bin
 * @property {number} score
 * @property {string | null} unsettled why the ball did not land
 * @property {string} digest
 *
 * @typedef {(t: number, impact: {x: number, y: number, kind: number, index: number, speed: number}
 *   ) => void} Hear t: table time, s; m and m/s
 */

const AHEAD = 30; // ticks that are sampled in one call

/**
 * Keyframes lie at each tick and on both sides of each event. The curve between two of them differs
 * from the ball's path by less than a micrometre. Times are the table's.
 */
export class PathFeed {
  #next = 0; // index of the next event
  #tick;
  /** @type {State[]} at the ticks from #tick on */
  #ahead = [];
  /** @type {State[]} right before each event */
  #before;
  #begun = false;

  /**
   * @param {Path} path
   * @param {Solved} course
   * @param {Board} board
   * @param {{start: number, from: number, rate: number}} times start: of the ball, from: of its
   *   keyframes, table time in s; rate: ticks a second
   */
  constructor(path, course, board, { start, from, rate }) {
    this.path = path;
    this.course = course;
    this.board = board;
    this.start = start;
    this.from = Math.max(start, from);
    this.rate = rate;
    this.#before = course.before();
    this.#tick = Math.floor(this.from * rate) + 1;
    while (this.#eventTime() <= this.from) this.#next += 1;
  }

  /** Table time at which the drop ends, s. */
  get end() {
    return this.start + this.course.duration;
  }

  /** @returns {{vx: number, vy: number} | null} velocity at the landing, m/s; null if it does not land */
  get sink() {
    const last = this.course.impacts.at(-1);
    return last?.[6] === LANDING ? { vx: last[3], vy: last[4] } : null;
  }

  /**
   * Makes the keyframes up to a time.
   * @param {number} t table time, s
   * @param {Hear} [hear] called with each impact on the way
   */
  until(t, hear) {
    if (t < this.from) return;
    if (!this.#begun) this.#begin();
    const last = Math.min(t, this.end);
    for (;;) {
      const [tick, event] = [this.#tick / this.rate, this.#eventTime()];
      if (Math.min(tick, event) > last) return;
      if (event <= tick) this.#happen(event, hear);
      else this.#pass(tick);
      if (event === tick) this.#skip();
    }
  }

  #begin() {
    this.#begun = true;
    const [state] = this.course.states([Math.min(this.from - this.start, this.course.duration)]);
    this.#keyframe(this.from, state, true);
  }

  /** @returns {number} table time of the next event */
  #eventTime() {
    const impact = this.course.impacts[this.#next];
    return impact ? this.start + impact[0] : Number.POSITIVE_INFINITY;
  }

  /** @param {number} t */
  #pass(t) {
    if (this.#ahead.length === 0) {
      const ticks = Array.from({ length: AHEAD }, (_, i) => (this.#tick + i) / this.rate);
      this.#ahead = this.course.states(ticks.map((at) => Math.max(0, at - this.start)));
    }
    this.#keyframe(t, this.#ahead[0], true);
    this.#skip();
  }

  #skip() {
    this.#ahead.shift();
    this.#tick += 1;
  }

  /** @param {number} t @param {Hear} [hear] */
  #happen(t, hear) {
    const before = this.#before[this.#next];
    const [, x, y, vx, vy, omega, kind, index] = this.course.impacts[this.#next];
    this.#next += 1;
    this.#keyframe(t, before, true);
    this.#keyframe(t, { ...before, x, y, vx, vy, omega }, false);
    if (!hear || (kind !== PEG && kind !== WALL)) return;
    const normal = normalAt(this.board, kind, index, { x, y });
    const speed = Math.max(0, -(before.vx * normal.x + before.vy * normal.y));
    hear(t, { x, y, kind, index, speed });
  }

  /** @param {number} t @param {State} state @param {boolean} smooth false right after an event */
  #keyframe(t, { x, y, theta: angle, vx, vy }, smooth) {
    this.path.add({ t, x, y, angle, vx, vy, vIn: smooth, vOut: true, smooth });
  }
}
