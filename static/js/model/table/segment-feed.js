// One ball's pieces made into knots of its path, as time passes. Pure.

import { normalAt } from "../impact.js";
import { KIND, piecePose, pieceVelocity } from "../../net/segments.js";

/** @typedef {import("../../net/segments.js").Piece} Piece */

/**
 * A piece does not say where it ends, so its knots are made only for the time that is drawn: at its
 * beginning, at each tick, and at its end once the next piece is known. A ball whose next piece is
 * late waits at what it would fly into. Times are the table's.
 */
export class PieceFeed {
  /** @type {Piece[]} in time order; the first is the one in use */
  #pieces = [];
  #at = Number.NEGATIVE_INFINITY;
  #end = Number.POSITIVE_INFINITY;
  #waits = false;

  /**
   * @param {import("../motion/path.js").Path} path
   * @param {any} board
   * @param {import("./obstacles.js").Obstacles} obstacles
   * @param {number} rate ticks a second
   */
  constructor(path, board, obstacles, rate) {
    Object.assign(this, { path, board, obstacles, rate });
  }

  /**
   * @param {Piece} piece may come twice
   * @returns {number} the speed in m/s at which the ball hit what the piece begins with; 0 for none
   */
  add(piece) {
    const pieces = this.#pieces;
    const last = pieces[pieces.length - 1];
    if (last && piece.t <= last.t) return 0;
    pieces.push(piece);
    this.#resume(piece.t);
    return last ? this.#approach(last, piece) : 0;
  }

  /** @param {number} t table time up to which knots are wanted, s */
  until(t) {
    const pieces = this.#pieces;
    const last = Math.min(t, this.#end);
    while (pieces.length) {
      const end = pieces.length > 1 ? pieces[1].t : Number.POSITIVE_INFINITY;
      this.#fill(pieces[0], Math.min(last, end));
      if (last < end) return;
      this.#turn(pieces.shift(), pieces[0]);
    }
  }

  /** @param {number} t when the ball's drop ended: nothing follows it */
  finish(t) {
    this.#resume(t);
    this.#end = t;
    this.until(t);
    const [piece] = this.#pieces;
    if (piece && this.#at < t) this.#knot(piece, t, true);
  }

  /** What was drawn beyond a time was a guess, and is taken back. */
  #resume(t) {
    if (this.#waits) {
      this.path.knots[this.path.knots.length - 1].vOut = true;
      this.#waits = false;
    }
    if (t >= this.#at) return;
    this.path.rewind(t);
    this.#at = this.path.end;
  }

  /** From one piece to the next: the last moment of a curve is no flight towards a place. */
  #turn(piece, next) {
    if (this.#at < next.t) this.#knot(piece, next.t, true);
    this.#knot(next, next.t, false);
  }

  #fill(piece, end) {
    if (this.#at < piece.t) {
      if (piece.t > end) return;
      this.#knot(piece, piece.t, false);
    }
    for (let tick = Math.floor(this.#at * this.rate) + 1; tick / this.rate < end; tick += 1) {
      if (this.#waits) return;
      this.#knot(piece, tick / this.rate, true);
    }
  }

  /** @param {boolean} smooth whether it lies on the piece, not at its beginning */
  #knot(piece, t, smooth) {
    const { x, y, angle } = piecePose(piece, t, this.board, pose);
    if (smooth && this.#blocked(x, y)) {
      this.path.knots[this.path.knots.length - 1].vOut = false;
      this.#waits = true;
      return;
    }
    const { vx, vy } = pieceVelocity(piece, t, this.board);
    this.path.add({ t, x, y, angle, vx, vy, vIn: smooth, vOut: true, smooth });
    this.#at = t;
  }

  /** Only of a guess: where the next piece is known, the one before it holds to its end. */
  #blocked(x, y) {
    if (this.#pieces.length > 1 || this.#end < Number.POSITIVE_INFINITY) return false;
    const { x: fromX, y: fromY } = this.path.knots[this.path.knots.length - 1];
    return y > this.board.bins.y || this.obstacles.stop(fromX, fromY, x, y);
  }

  #approach(last, { kind, index, ax, x, y, t }) {
    if (ax !== undefined || (kind !== KIND.offPeg && kind !== KIND.offWall)) return 0;
    if (!(kind === KIND.offPeg ? this.board.pegs : this.board.walls)[index]) return 0;
    const normal = normalAt(this.board, kind, index, { x, y });
    const { vx, vy } = pieceVelocity(last, t, this.board);
    return Math.max(0, -(vx * normal.x + vy * normal.y));
  }
}

const pose = { x: 0, y: 0, angle: 0 };
