// Paths in pieces: frames of `?stream=segments` in, the exact place of a ball at any time out. Pure.

import { basis } from "../model/motion/flight.js";
import { ProtocolError } from "./protocol.js";

const MAGIC = 0x53;
const VERSION = 2;
const HEADER_BYTES = 16;
const FLIGHT_BYTES = 18;
const CURVE_BYTES = 26;
const STEPS = 1024; // of a tick, in which the age of a piece is told
const GRID = 65535;
const FULL = 1;

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
 * its start; a curve has an even acceleration of its own.
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
  const { psi } = basis(curved ? 0 : drag, s);
  out.x = piece.x + piece.vx * s + ax * psi;
  out.y = piece.y + piece.vy * s + ay * psi;
  out.angle = piece.angle + piece.spin * s;
  return out;
}

/**
 * @param {Piece} piece
 * @param {number} t table time, s
 * @param {Law} law
 * @returns {{vx: number, vy: number}} m/s; along a curve it is no exact velocity of the ball
 */
export function pieceVelocity(piece, t, { gravity, drag }) {
  const s = t - piece.t;
  if (piece.ax !== undefined) return { vx: piece.vx + piece.ax * s, vy: piece.vy + piece.ay * s };
  const { phi } = basis(drag, s);
  return {
    vx: piece.vx - drag * piece.vx * phi,
    vy: piece.vy + (gravity - drag * piece.vy) * phi,
  };
}
