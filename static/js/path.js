// One ball's known path: knots in time order, and the pose at any time. Pure.

import { flightPose, poseBetween, shortestTurn } from "./interpolate.js";

const MAX_GUESS = 0.05; // s of flight past the newest knot; then it waits for news

const LINE_RATE = 120; // points a second when the whole path is wanted

/** @typedef {import("./interpolate.js").Knot} Knot */

/** The knots of one ball, kept from its start so that the whole path can be drawn. */
export class Path {
  /** @type {Knot[]} */
  knots = [];
  #hint = 0;

  /** @param {import("./interpolate.js").Law} law */
  constructor(law) {
    this.law = law;
  }

  /** @param {Knot} knot may arrive late: a contact's place comes after the snapshot it precedes */
  add(knot) {
    const { knots } = this;
    let at = knots.length;
    while (at > 0 && knots[at - 1].t > knot.t) at -= 1;
    knots.splice(at, 0, knot);
    this.#turnThrough(at);
    // A bounce with a known place needs no guess about where it was.
    if (!knot.vIn && knots[at + 1]) knots[at + 1].bounced = false;
    if (knot.bounced && knots[at - 1] && !knots[at - 1].vIn) knot.bounced = false;
  }

  /** Contacts come without an angle: theirs lies on the line between the snapshots around them. */
  #turnThrough(at) {
    const { knots } = this;
    let before = at;
    while (before > 0 && !knots[before].vIn) before -= 1;
    let after = at;
    while (after < knots.length - 1 && !knots[after].vIn) after += 1;
    const a = knots[before];
    const b = knots[after];
    const turn = b.vIn ? shortestTurn(a.angle, b.angle) : 0;
    for (let i = before + 1; i <= after; i += 1) {
      if (!knots[i].vIn) knots[i].angle = a.angle + (turn * (knots[i].t - a.t)) / (b.t - a.t || 1);
    }
    // The new knot may also close a gap of contacts that arrived before it.
    if (knots[at].vIn && at > 0 && !knots[at - 1].vIn) this.#turnThrough(at - 1);
  }

  get start() {
    return this.knots.length ? this.knots[0].t : Number.POSITIVE_INFINITY;
  }

  get end() {
    return this.knots.length ? this.knots[this.knots.length - 1].t : Number.NEGATIVE_INFINITY;
  }

  /**
   * @param {number} t seconds
   * @param {import("./interpolate.js").Pose} [out]
   */
  poseAt(t, out = { x: 0, y: 0, angle: 0 }) {
    const { knots } = this;
    const last = knots[knots.length - 1];
    if (t >= last.t) return this.#beyond(last, t, out);
    if (t <= knots[0].t) return Object.assign(out, pick(knots[0]));
    const i = this.#indexBefore(t);
    return poseBetween(knots[i], knots[i + 1], t, this.law, out);
  }

  /** @returns {{x: number, y: number}[]} the whole of it, a point every 1/120 s */
  line() {
    const count = Math.ceil((this.end - this.start) * LINE_RATE) + 1;
    return Array.from({ length: count }, (_, step) =>
      this.poseAt(Math.min(this.end, this.start + step / LINE_RATE)));
  }

  #beyond(last, t, out) {
    out.angle = last.angle;
    if (last.vOut) return flightPose(last, Math.min(t, last.t + MAX_GUESS), this.law, out);
    return Object.assign(out, pick(last));
  }

  /** Time moves a little between calls, so the last answer is the best place to look from. */
  #indexBefore(t) {
    const { knots } = this;
    let i = Math.min(this.#hint, knots.length - 2);
    while (i > 0 && knots[i].t > t) i -= 1;
    while (i < knots.length - 2 && knots[i + 1].t <= t) i += 1;
    this.#hint = i;
    return i;
  }
}

function pick({ x, y, angle }) {
  return { x, y, angle };
}
