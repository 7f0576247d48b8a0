// One ball's known path: knots in time order, and the pose at any time. Pure.

import { flightPose, poseBetween, shortestTurn } from "./interpolate.js";

const MAX_GUESS = 0.05; // s of flight past the newest knot; then it waits for news
const LINE_RATE = 120; // points a second when the whole path is wanted

/** @typedef {import("./interpolate.js").Knot} Knot */

/** Knots no path needs any more. Sixty a second and ball would keep the collector busy. */
const spare = [];
const MAX_SPARE = 16384;

/** The knots of one ball; a live one forgets those that time has passed. */
export class Path {
  /** @type {Knot[]} */
  knots = [];
  #hint = 0;

  /**
   * @param {import("./interpolate.js").Law} law
   * @param {number} [most] knots kept; beyond it the oldest go, so that nothing grows without end
   */
  constructor(law, most = Number.POSITIVE_INFINITY) {
    this.law = law;
    this.most = most;
  }

  /**
   * @param {Partial<Knot> & {t: number}} moment copied; may arrive late: a contact's place comes
   *   after the snapshot it precedes
   */
  add(moment) {
    const { knots } = this;
    const knot = fill(spare.pop() ?? blank(), moment);
    let at = knots.length;
    while (at > 0 && knots[at - 1].t > knot.t) at -= 1;
    knots.push(knot);
    for (let i = knots.length - 1; i > at; i -= 1) knots[i] = knots[i - 1];
    knots[at] = knot;
    this.#turnThrough(at);
    // A bounce with a known place needs no guess about where it was.
    if (!knot.vIn && knots[at + 1]) knots[at + 1].bounced = false;
    if (knot.bounced && knots[at - 1] && !knots[at - 1].vIn) knot.bounced = false;
    if (knots.length > this.most) this.forget(knots[1].t);
  }

  /**
   * Gives up what lies wholly before a time; the pose at that time and after it stays as it was.
   * @param {number} before s
   * @param {(a: Knot, b: Knot, law: import("./interpolate.js").Law) => void} [visit] sees each
   *   stretch that goes, in order; it must not keep the knots
   */
  forget(before, visit) {
    const { knots } = this;
    let gone = 0;
    while (gone < knots.length - 1 && knots[gone + 1].t <= before) {
      visit?.(knots[gone], knots[gone + 1], this.law);
      gone += 1;
    }
    if (gone === 0) return;
    for (let i = 0; i < gone; i += 1) if (spare.length < MAX_SPARE) spare.push(knots[i]);
    for (let i = gone; i < knots.length; i += 1) knots[i - gone] = knots[i];
    knots.length -= gone;
    this.#hint = Math.max(0, this.#hint - gone);
  }

  /** @param {number} t takes back all knots after it: what was foreseen has turned out otherwise */
  rewind(t) {
    const { knots } = this;
    while (knots.length && knots[knots.length - 1].t > t) {
      const knot = knots.pop();
      if (spare.length < MAX_SPARE) spare.push(knot);
    }
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
    if (t <= knots[0].t) return pick(knots[0], out);
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
    return pick(last, out);
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

/** @returns {Knot} */
function blank() {
  return {
    t: 0, x: 0, y: 0, angle: 0, vx: 0, vy: 0, vIn: false, vOut: false, bounced: false,
    smooth: false,
  };
}

function fill(knot, moment) {
  const { t, x, y, angle = 0, vx = 0, vy = 0, vIn, vOut, bounced = false, smooth = false } = moment;
  knot.t = t;
  knot.x = x;
  knot.y = y;
  knot.angle = angle;
  knot.vx = vx;
  knot.vy = vy;
  knot.vIn = vIn;
  knot.vOut = vOut;
  knot.bounced = bounced;
  knot.smooth = smooth;
  return knot;
}

function pick({ x, y, angle }, out) {
  out.x = x;
  out.y = y;
  out.angle = angle;
  return out;
}
