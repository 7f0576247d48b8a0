// Turns the segments of one ball into keyframes of its path, as time passes. Pure.

import { normalAt } from "../impact.js";
import { KIND, segmentPose, segmentVelocity } from "../motion/segment.js";

/** @import { Board } from "../board.js" */
/** @import { Path } from "../motion/path.js" */
/** @import { Segment } from "../motion/segment.js" */
/** @import { Obstacles } from "./obstacles.js" */
/** @import { Law } from "../motion/interpolate.js" */

/** @typedef {Law & Pick<Board, "pegs" | "walls" | "bins">} Surroundings */

/**
 * A segment does not say where it ends. Its keyframes are therefore made only as far as the table has
 * been drawn: at its beginning, at each tick, and at its end as soon as the next segment is known. While
 * the next segment is late, the ball waits at the peg or wall that it would otherwise fly into. Times
 * are the table's.
 */
export class SegmentFeed {
  /** @type {Segment[]} in time order; the ball is on the first */
  #segments = [];
  #at = Number.NEGATIVE_INFINITY;
  #end = Number.POSITIVE_INFINITY;
  #waits = false;

  /**
   * @param {Path} path
   * @param {Surroundings} board
   * @param {Pick<Obstacles, "stop">} obstacles
   * @param {number} rate ticks a second
   */
  constructor(path, board, obstacles, rate) {
    this.path = path;
    this.board = board;
    this.obstacles = obstacles;
    this.rate = rate;
  }

  /**
   * @param {Segment} segment one that was already added is ignored
   * @returns {number} the speed of the impact that the segment begins with, m/s; 0 if it begins otherwise
   */
  add(segment) {
    const segments = this.#segments;
    const last = segments[segments.length - 1];
    if (last && segment.t <= last.t) return 0;
    segments.push(segment);
    this.#resume(segment.t);
    return last ? this.#approach(last, segment) : 0;
  }

  /** Makes the keyframes up to a time. @param {number} t table time, s */
  until(t) {
    const segments = this.#segments;
    const last = Math.min(t, this.#end);
    while (segments.length) {
      const end = segments.length > 1 ? segments[1].t : Number.POSITIVE_INFINITY;
      this.#fill(segments[0], Math.min(last, end));
      if (last < end) return;
      const [segment, next] = segments;
      if (!next) return;
      segments.shift();
      this.#turn(segment, next);
    }
  }

  /** Ends the path. @param {number} t when the drop ended, table time, s */
  finish(t) {
    this.#resume(t);
    this.#end = t;
    this.until(t);
    const [segment] = this.#segments;
    if (segment && this.#at < t) this.#keyframe(segment, t, true);
  }

  /** Removes the keyframes after t, which were a guess. @param {number} t */
  #resume(t) {
    if (this.#waits) {
      this.path.keyframes[this.path.keyframes.length - 1].vOut = true;
      this.#waits = false;
    }
    if (t >= this.#at) return;
    this.path.rewind(t);
    this.#at = this.path.end;
  }

  /**
   * Adds two keyframes where one segment meets the next: the end of the first, the beginning of the second.
   * @param {Segment} segment
   * @param {Segment} next
   */
  #turn(segment, next) {
    if (this.#at < next.t) this.#keyframe(segment, next.t, true);
    this.#keyframe(next, next.t, false);
  }

  /** @param {Segment} segment @param {number} end */
  #fill(segment, end) {
    if (this.#at < segment.t) {
      if (segment.t > end) return;
      this.#keyframe(segment, segment.t, false);
    }
    for (let tick = Math.floor(this.#at * this.rate) + 1; tick / this.rate < end; tick += 1) {
      if (this.#waits) return;
      this.#keyframe(segment, tick / this.rate, true);
    }
  }

  /**
   * @param {Segment} segment
   * @param {number} t
   * @param {boolean} smooth false at the segment's beginning
   */
  #keyframe(segment, t, smooth) {
    const { x, y, angle } = segmentPose(segment, t, this.board, pose);
    if (smooth && this.#blocked(x, y)) {
      this.path.keyframes[this.path.keyframes.length - 1].vOut = false;
      this.#waits = true;
      return;
    }
    const { vx, vy } = segmentVelocity(segment, t, this.board);
    this.path.add({ t, x, y, angle, vx, vy, vIn: smooth, vOut: true, smooth });
    this.#at = t;
  }

  /**
   * Whether a guess would lead into a peg, a wall or past the bins. While the next segment or the end is
   * known, the path is no guess.
   * @param {number} x
   * @param {number} y
   */
  #blocked(x, y) {
    if (this.#segments.length > 1 || this.#end < Number.POSITIVE_INFINITY) return false;
    const { x: fromX, y: fromY } = this.path.keyframes[this.path.keyframes.length - 1];
    return y > this.board.bins.y || this.obstacles.stop(fromX, fromY, x, y);
  }

  /** @param {Segment} last @param {Segment} segment */
  #approach(last, { kind, index, bend, x, y, t }) {
    if (bend || (kind !== KIND.offPeg && kind !== KIND.offWall)) return 0;
    if (!(kind === KIND.offPeg ? this.board.pegs : this.board.walls)[index]) return 0;
    const normal = normalAt(this.board, kind, index, { x, y });
    const { vx, vy } = segmentVelocity(last, t, this.board);
    return Math.max(0, -(vx * normal.x + vy * normal.y));
  }
}

const pose = { x: 0, y: 0, angle: 0 };
