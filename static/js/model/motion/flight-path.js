// The path of a ball as the stream `paths` sends it: knots, and the law of motion between them. Pure.

import { CONTACT_CHANGE, LANDING, PEG, WALL } from "./drop.js";
import { basis } from "./flight.js";

/** @import { Board } from "../board.js" */
/** @import { ImpactRow } from "./drop.js" */
/** @import { State } from "./flight.js" */

/** Numbers of a knot: t, x, y, angle, ax, ay, hit; docs/protocol.md describes each. */
export const KNOT = 7;
const CLOSE = 1e-4; // m above the bins, at which a path that ends has landed
const [T, X, Y, ANGLE, AX, AY, HIT] = [0, 1, 2, 3, 4, 5, 6];

/** The known part of a path; times in s since the ball's start. */
export class FlightPath {
  /** @type {ImpactRow[]} the bounces, and the end of the path */
  impacts = [];
  /** @type {number[]} the knot of each */
  #at = [];

  /**
   * @param {Float32Array} knots in the order of time
   * @param {Pick<Board, "drag" | "pegs" | "bins">} board
   */
  constructor(knots, { drag, pegs, bins }) {
    this.knots = knots;
    this.drag = drag;
    this.last = knots.length / KNOT - 1;
    for (let i = 1; i < this.last; i += 1) {
      const hit = this.#of(i, HIT);
      if (hit >= pegs.length) this.#happens(i, this.#state(i, 0), WALL, hit - pegs.length);
      else if (hit >= 0) this.#happens(i, this.#state(i, 0), PEG, hit);
    }
    const end = this.#end(this.last - 1);
    this.#happens(this.last, end, end.y > bins.y - CLOSE ? LANDING : CONTACT_CHANGE, 0);
  }

  /** @param {number} knot @param {State} after @param {number} kind @param {number} index */
  #happens(knot, { t, x, y, vx, vy, omega }, kind, index) {
    this.impacts.push([t, x, y, vx, vy, omega, kind, index]);
    this.#at.push(knot);
  }

  get duration() {
    return this.#of(this.last, T);
  }

  /** @param {number[]} times @returns {State[]} */
  states(times) {
    return times.map((t) => {
      const piece = this.#pieceAt(t);
      return { ...this.#state(piece, t - this.#of(piece, T)), t };
    });
  }

  /** @returns {State[]} right before each impact */
  before() {
    return this.#at.map((knot) => this.#end(knot - 1));
  }

  /** @param {number} knot @param {number} column @returns {number} */
  #of(knot, column) {
    return this.knots[KNOT * knot + column];
  }

  /** @param {number} piece @returns {State} at its end */
  #end(piece) {
    return this.#state(piece, this.#of(piece + 1, T) - this.#of(piece, T));
  }

  /** @param {number} piece from this knot to the next @param {number} s seconds since the knot @returns {State} */
  #state(piece, s) {
    const { drag } = this;
    const h = this.#of(piece + 1, T) - this.#of(piece, T);
    const [whole, part] = [basis(drag, h), basis(drag, s)];
    /** @param {number} place @param {number} push */
    const along = (place, push) => {
      const [from, a] = [this.#of(piece, place), this.#of(piece, push)];
      const v = (this.#of(piece + 1, place) - from - a * whole.psi) / whole.phi;
      return [from + v * part.phi + a * part.psi, v * (1 - drag * part.phi) + a * part.phi];
    };
    const [[x, vx], [y, vy]] = [along(X, AX), along(Y, AY)];
    const omega = (this.#of(piece + 1, ANGLE) - this.#of(piece, ANGLE)) / h;
    return { t: this.#of(piece, T) + s, x, y, vx, vy, theta: this.#of(piece, ANGLE) + omega * s, omega };
  }

  /** @param {number} t @returns {number} the last knot at or before it that begins a piece */
  #pieceAt(t) {
    let [low, high] = [0, this.last];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.#of(middle, T) <= t) low = middle;
      else high = middle;
    }
    return low;
  }
}

/**
 * The knots of two parts of a path; the later part begins with the last knot of the earlier.
 * @param {Float32Array} one
 * @param {Float32Array} other
 */
export function joined(one, other) {
  const [first, second] = one[T] < other[T] ? [one, other] : [other, one];
  const knots = new Float32Array(first.length + second.length - KNOT);
  knots.set(first);
  knots.set(second, first.length - KNOT);
  return knots;
}
