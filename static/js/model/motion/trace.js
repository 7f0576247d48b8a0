// A whole path in bounded memory: when the memory is full, every second point is removed. Pure.

import { poseBetween } from "./interpolate.js";

/** @import { Keyframe, Law } from "./interpolate.js" */
/** @import { Point } from "../board.js" */

const POINTS = 2048;
const STEP = 1 / 120; // s between points, until the first thinning

/** Points of one ball's path, for players who see the path only after the landing (reduced motion). */
export class Trace {
  /** @type {Point[]} */
  points = [];
  #step = STEP;
  #next = Number.NEGATIVE_INFINITY;

  /**
   * Adds the stretch between two keyframes; stretches must come in order.
   * @param {Keyframe} a
   * @param {Keyframe} b
   * @param {Law} law
   */
  follow(a, b, law) {
    for (let t = Math.max(a.t, this.#next); t < b.t; t += this.#step) {
      this.#add(poseBetween(a, b, t, law));
      this.#next = t + this.#step;
    }
    // A bounce is a corner, which the points before and after it would cut off.
    if (!b.vIn) this.#add(b);
  }

  /** @param {Point} point */
  #add({ x, y }) {
    if (this.points.length === POINTS) {
      this.points = this.points.filter((_, i) => i % 2 === 0);
      this.#step *= 2;
    }
    this.points.push({ x, y });
  }
}
