// One ball's fall: where it is at any time, and at which rows it went right. Pure.

import { CONTACT_BEGIN, CONTACT_CHANGE } from "../model/motion/kinds.js";

/** @import { Board, Point } from "../model/board.js" */
/** @import { Drop } from "../solver/drop.js" */

const KNOT = 6; // t, x, y, vx, vy, acceleration downwards

/** The path of a ball that falls without air. */
export class Fall {
  #knots;
  #pegs;

  /** @param {Drop} drop @param {Board} board */
  constructor(drop, board) {
    const { drop: { y }, gravity } = board;
    this.bin = drop.bin;
    this.end = drop.duration;
    this.#pegs = board.pegs;
    const knots = [0, drop.xStart, y, 0, 0, gravity];
    drop.impacts.forEach(([t, x, atY, vx, vy, , kind], i) => {
      const next = drop.impacts[i + 1];
      const touches = (kind === CONTACT_BEGIN || kind === CONTACT_CHANGE) && next && next[0] > t;
      // On a peg it rolls; a straight line to the next event differs by less than a tenth of a millimetre.
      const [across, down] = touches ? [(next[1] - x) / (next[0] - t), (next[2] - atY) / (next[0] - t)] : [vx, vy];
      knots.push(t, x, atY, across, down, touches ? 0 : gravity);
    });
    this.#knots = Float64Array.from(knots);
  }

  /** @param {number} t s since the start, before the end @returns {Point} m */
  placeAt(t) {
    const knots = this.#knots;
    let [low, high] = [0, knots.length / KNOT];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (knots[KNOT * middle] <= t) low = middle;
      else high = middle;
    }
    const [from, x, y, vx, vy, g] = knots.subarray(KNOT * low, KNOT * (low + 1));
    const s = t - from;
    return { x: x + vx * s, y: y + s * (vy + 0.5 * g * s) };
  }

  /** @param {number} to s @param {number} [step] s @returns {Point[]} the path up to a time, m */
  pathTo(to, step = 0.01) {
    const times = Array.from({ length: Math.ceil(to / step) }, (_, i) => i * step);
    return [...times, to].map((t) => this.placeAt(t));
  }

  /** @returns {boolean[]} for each row, from above, whether the ball went right there */
  get turns() {
    const knots = this.#knots;
    const pegs = this.#pegs;
    /** @type {number[]} in each row, the number of the gap */
    const gaps = [];
    for (let first = 0, row = 0; first < pegs.length; first += row + 3, row += 1) {
      const { y } = pegs[first];
      let last = knots.length / KNOT - 1;
      while (last > 0 && knots[KNOT * last + 2] > y) last -= 1; // the last knot above the row: it passes after it
      const [, x, from, vx, vy, g] = knots.subarray(KNOT * last, KNOT * (last + 1));
      const s = g === 0 ? (y - from) / vy : (Math.sqrt(vy * vy + 2 * g * (y - from)) - vy) / g;
      let gap = 0;
      while (gap < row + 1 && pegs[first + gap + 1].x < x + vx * s) gap += 1;
      gaps.push(gap);
    }
    return gaps.map((gap, row) => gap > (gaps[row - 1] ?? 0));
  }
}
