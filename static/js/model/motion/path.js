// One ball's known path: keyframes in time order, and the pose at any time. Pure.

import { flightPlace, poseBetween, shortestTurn } from "./interpolate.js";

/** @import { Keyframe, Law, Pose } from "./interpolate.js" */

const MAX_GUESS = 0.05; // s of flight past the newest keyframe; after that the ball stops until the next

/**
 * A keyframe to add; missing fields are 0 or false.
 * @typedef {Pick<Keyframe, "t" | "x" | "y" | "vIn" | "vOut"> & Partial<Keyframe>} Moment
 */

/** @type {Keyframe} */
const BLANK = { t: 0, x: 0, y: 0, angle: 0, vx: 0, vy: 0, vIn: false, vOut: false, bounced: false, smooth: false };

/** The keyframes of one ball. A live table forgets those that its time has passed. */
export class Path {
  /** @type {Keyframe[]} */
  keyframes = [];

  /**
   * @param {Law} law
   * @param {number} [most] keyframes kept; the oldest are removed beyond this number
   */
  constructor(law, most = Number.POSITIVE_INFINITY) {
    this.law = law;
    this.most = most;
  }

  /**
   * @param {Moment} moment may be earlier than keyframes already added: a contact arrives
   *   after the snapshot that it precedes
   */
  add(moment) {
    const { keyframes } = this;
    const keyframe = { ...BLANK, ...moment };
    let at = keyframes.length;
    while (at > 0 && keyframes[at - 1].t > keyframe.t) at -= 1;
    keyframes.splice(at, 0, keyframe);
    this.#turnThrough(at);
    // The place of this bounce is known, so poseBetween need not guess it.
    if (!keyframe.vIn && keyframes[at + 1]) keyframes[at + 1].bounced = false;
    if (keyframe.bounced && keyframes[at - 1] && !keyframes[at - 1].vIn) keyframe.bounced = false;
    if (keyframes.length > this.most) this.forget(keyframes[1].t);
  }

  /**
   * Removes the keyframes that only poses before this time need.
   * @param {number} before s
   * @param {(a: Keyframe, b: Keyframe, law: Law) => void} [visit] called with each pair of neighbours
   *   whose stretch is removed, in order
   */
  forget(before, visit) {
    const { keyframes } = this;
    let gone = 0;
    for (; gone < keyframes.length - 1 && keyframes[gone + 1].t <= before; gone += 1) {
      visit?.(keyframes[gone], keyframes[gone + 1], this.law);
    }
    if (gone > 0) keyframes.splice(0, gone);
  }

  /**
   * Interpolates the angles of contacts, which arrive without one, between the snapshots around them.
   * @param {number} at
   */
  #turnThrough(at) {
    const { keyframes } = this;
    let before = at;
    while (before > 0 && !keyframes[before].vIn) before -= 1;
    let after = at;
    while (after < keyframes.length - 1 && !keyframes[after].vIn) after += 1;
    const a = keyframes[before];
    const b = keyframes[after];
    const turn = b.vIn ? shortestTurn(a.angle, b.angle) : 0;
    for (let i = before + 1; i <= after; i += 1) {
      if (!keyframes[i].vIn) keyframes[i].angle = a.angle + (turn * (keyframes[i].t - a.t)) / (b.t - a.t || 1);
    }
    // The new keyframe may also close a gap of contacts that arrived before it.
    if (keyframes[at].vIn && at > 0 && !keyframes[at - 1].vIn) this.#turnThrough(at - 1);
  }

  get start() {
    return this.keyframes.length ? this.keyframes[0].t : Number.POSITIVE_INFINITY;
  }

  get end() {
    return this.keyframes.length ? this.keyframes[this.keyframes.length - 1].t : Number.NEGATIVE_INFINITY;
  }

  /** @param {number} t seconds @returns {Pose} */
  poseAt(t) {
    const { keyframes } = this;
    const last = keyframes[keyframes.length - 1];
    if (t >= last.t) return this.#beyond(last, t);
    if (t <= keyframes[0].t) return keyframes[0];
    let i = keyframes.length - 2;
    while (i > 0 && keyframes[i].t > t) i -= 1;
    return poseBetween(keyframes[i], keyframes[i + 1], t, this.law);
  }

  /** @param {Keyframe} last @param {number} t @returns {Pose} */
  #beyond(last, t) {
    if (!last.vOut) return last;
    const { x, y } = flightPlace(last, Math.min(t, last.t + MAX_GUESS), this.law);
    return { x, y, angle: last.angle };
  }
}
