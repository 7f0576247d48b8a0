// Paths in pieces: frames of `?stream=segments` in, the exact place of a ball at any time out. Pure.

import { ProtocolError } from "./protocol.js";

const MAGIC = 0x53;
const VERSION = 2;
const HEADER_BYTES = 16;
const FLIGHT_BYTES = 18;
const CURVE_BYTES = 26;
const STEPS = 1024; // of a tick, in which the age of a piece is told
const GRID = 65535;
const FULL = 1;
const LINE_RATE = 120; // points a second when the whole path is wanted
const SERIES_LIMIT = 1e-3; // of drag times time: below it the closed form of psi cancels

/** What a piece begins with, or for a curve what it runs along. */
export const KIND = { offPeg: 0, offWall: 1, leftPeg: 2, leftWall: 3, dropped: 4, underWay: 5 };

/**
 * A stretch of a path: free flight, or where ax and ay are numbers a parabola along a surface.
 * @typedef {object} Piece
 * @property {number} id ball number mod 65536
 * @property {number} kind one of KIND
 * @property {number} index of the peg or wall
 * @property {number} t its start, table time: seconds since the room's
 * @property {number} x metres
 * @property {number} y metres, down
 * @property {number} vx m/s
 * @property {number} vy m/s
 * @property {number} angle radians, clockwise
 * @property {number} spin rad/s
 * @property {number} [ax] m/s^2
 * @property {number} [ay]
 */

/**
 * What the numbers of a frame mean; the hello tells it.
 * @typedef {object} Scale
 * @property {{x_min: number, x_max: number, y_min: number, y_max: number}} extent metres
 * @property {number} velocityScale m/s of one step of a snapshot's velocity, two of a piece's
 * @property {number} spinScale rad/s of one step of a piece's spin
 * @property {number} rate ticks a second
 */

/** @typedef {{gravity: number, drag: number}} Law m/s^2 and 1/s */
/** @typedef {{x: number, y: number, angle: number}} Pose */

/**
 * @param {ArrayBuffer} buffer
 * @param {Scale} scale
 * @returns {{tick: number, seq: number, full: boolean, flights: Piece[], curves: Piece[]}}
 */
export function decodeSegments(buffer, scale) {
  const view = new DataView(buffer);
  const { flights, curves } = checkHeader(view);
  const tick = view.getUint32(4, true);
  const middle = HEADER_BYTES + flights * FLIGHT_BYTES;
  return {
    tick,
    seq: view.getUint32(8, true),
    full: (view.getUint8(14) & FULL) !== 0,
    flights: Array.from({ length: flights }, (_, i) =>
      readPiece(view, HEADER_BYTES + i * FLIGHT_BYTES, tick, scale)),
    curves: Array.from({ length: curves }, (_, i) => {
      const at = middle + i * CURVE_BYTES;
      const ax = view.getFloat32(at + 18, true);
      const ay = view.getFloat32(at + 22, true);
      return { ...readPiece(view, at, tick, scale), ax, ay };
    }),
  };
}

function readPiece(view, at, tick, { extent, velocityScale, spinScale, rate }) {
  const width = extent.x_max - extent.x_min;
  const height = extent.y_max - extent.y_min;
  return {
    id: view.getUint16(at, true),
    kind: view.getUint8(at + 2),
    angle: view.getUint8(at + 3) * ((2 * Math.PI) / 256),
    t: (tick - view.getUint16(at + 4, true) / STEPS) / rate,
    x: ((2 * view.getUint16(at + 6, true)) / GRID - 0.5) * width + extent.x_min,
    y: (view.getUint16(at + 8, true) / GRID) * height + extent.y_min,
    vx: view.getInt16(at + 10, true) * 0.5 * velocityScale,
    vy: view.getInt16(at + 12, true) * 0.5 * velocityScale,
    spin: view.getInt16(at + 14, true) * spinScale,
    index: view.getUint16(at + 16, true),
  };
}

/** @param {DataView} view @returns {{flights: number, curves: number}} how many follow */
function checkHeader(view) {
  if (view.byteLength < HEADER_BYTES) {
    throw new ProtocolError(`segments of ${view.byteLength} bytes are shorter than their header`);
  }
  if (view.getUint8(0) !== MAGIC) {
    throw new ProtocolError(`segments start with ${view.getUint8(0)}, not ${MAGIC}`);
  }
  if (view.getUint8(1) !== VERSION) {
    throw new ProtocolError(`segments version ${view.getUint8(1)} is not ${VERSION}`);
  }
  const flights = view.getUint16(2, true);
  const curves = view.getUint16(12, true);
  const expected = HEADER_BYTES + flights * FLIGHT_BYTES + curves * CURVE_BYTES;
  if (view.byteLength !== expected) {
    throw new ProtocolError(
      `${flights} flights and ${curves} curves have ${view.byteLength} bytes, not ${expected}`,
    );
  }
  return { flights, curves };
}

/**
 * Where a ball is on a piece. A flight is r + v s + a psi(s) with a = g - k v, the acceleration at
 * its start, and psi(s) = (s - phi(s)) / k, phi(s) = (1 - exp(-k s)) / k; s^2 / 2 without drag.
 * @param {Piece} piece
 * @param {number} t table time, s
 * @param {Law} law
 * @param {Pose} [out]
 */
export function piecePose(piece, t, { gravity, drag }, out = { x: 0, y: 0, angle: 0 }) {
  const s = t - piece.t;
  const curved = piece.ax !== undefined;
  const ax = curved ? piece.ax : -drag * piece.vx;
  const ay = curved ? piece.ay : gravity - drag * piece.vy;
  const bend = curved ? 0.5 * s * s : psi(drag, s);
  out.x = piece.x + piece.vx * s + ax * bend;
  out.y = piece.y + piece.vy * s + ay * bend;
  out.angle = piece.angle + piece.spin * s;
  return out;
}

function psi(k, s) {
  const z = k * s;
  if (Math.abs(z) < SERIES_LIMIT) return s * s * (0.5 - z / 6 + (z * z) / 24 - (z * z * z) / 120);
  return (s + Math.expm1(-z) / k) / k;
}

/** One ball's path from its pieces: what `Path` is for snapshots. Times are the table's. */
export class PiecePath {
  /** @type {Piece[]} in time order */
  pieces = [];
  #hint = 0;
  #since = Number.POSITIVE_INFINITY;
  #end = Number.POSITIVE_INFINITY;

  /** @param {Law} law */
  constructor(law) {
    this.law = law;
  }

  /** @param {Piece} piece may come twice, and late */
  add(piece) {
    const { pieces } = this;
    let at = pieces.length;
    while (at > 0 && pieces[at - 1].t >= piece.t) at -= 1;
    pieces.splice(at, pieces[at]?.t === piece.t ? 1 : 0, piece);
    this.#since = pieces[0].t;
  }

  /** Whether anything is known of it. */
  get known() {
    return this.pieces.length > 0;
  }

  get start() {
    return this.#since;
  }

  /** @param {number} t table time at which the ball's drop ends */
  finish(t) {
    this.#end = t;
  }

  /**
   * @param {number} t table time
   * @param {Pose} [out]
   */
  poseAt(t, out = { x: 0, y: 0, angle: 0 }) {
    const known = Math.max(Math.min(t, this.#end), this.#since);
    return piecePose(this.#pieceAt(known), known, this.law, out);
  }

  /** @returns {{x: number, y: number}[]} the whole of it, a point every 1/120 s */
  line() {
    const until = Math.min(this.#end, this.pieces[this.pieces.length - 1].t + 1);
    const count = Math.ceil((until - this.start) * LINE_RATE) + 1;
    return Array.from({ length: count }, (_, step) =>
      this.poseAt(Math.min(until, this.start + step / LINE_RATE)));
  }

  /** Time moves a little between calls, so the last answer is the best place to look from. */
  #pieceAt(t) {
    const { pieces } = this;
    let i = Math.min(this.#hint, pieces.length - 1);
    while (i > 0 && pieces[i].t > t) i -= 1;
    while (i < pieces.length - 1 && pieces[i + 1].t <= t) i += 1;
    this.#hint = i;
    return pieces[i];
  }
}
