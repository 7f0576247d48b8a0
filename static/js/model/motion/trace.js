// A whole path in bounded memory: when the memory is full, every second point is removed. Pure.

import { poseBetween } from "./interpolate.js";

/** @import { Keyframe, Law } from "./interpolate.js" */
/** @import { Point } from "../board.js" */

const POINTS = 2048;
const STEP = 1 / 120; // s between points, until the first thinning

/** Points of one ball's path, for players who see the path only after the landing (reduced motion). */
export class Trace {
  #x = new Float32Array(POINTS);
  #y = new Float32Array(POINTS);
  #step = STEP;
  #next = Number.NEGATIVE_INFINITY;
  count = 0;

  /**
   * Adds the stretch between two keyframes; stretches must come in order.
   * @param {Keyframe} a
   * @param {Keyframe} b
   * @param {Law} law
   */
  follow(a, b, law) {
    const pose = { x: 0, y: 0, angle: 0 };
    for (let t = Math.max(a.t, this.#next); t < b.t; t += this.#step) {
      poseBetween(a, b, t, law, pose);
      this.#add(pose);
      this.#next = t + this.#step;
    }
    // A bounce is a corner, which the points before and after it would cut off.
    if (!b.vIn) this.#add(b);
  }

  /** @returns {{x: number, y: number}[]} */
  points() {
    return Array.from({ length: this.count }, (_, i) => ({ x: this.#x[i], y: this.#y[i] }));
  }

  /** @param {Point} point */
  #add({ x, y }) {
    if (this.count === POINTS) this.#thin();
    this.#x[this.count] = x;
    this.#y[this.count] = y;
    this.count += 1;
  }

  #thin() {
    for (let i = 0; 2 * i < POINTS; i += 1) {
      this.#x[i] = this.#x[2 * i];
      this.#y[i] = this.#y[2 * i];
    }
    this.count = POINTS / 2;
    this.#step *= 2;
  }
}
