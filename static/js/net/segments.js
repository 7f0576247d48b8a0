// Decodes the binary messages of `?stream=segments` into segments of paths. Pure.

import { ProtocolError } from "./protocol.js";

/** @import { Segment } from "../model/motion/segment.js" */
/** @import { Extent, SegmentMessage } from "../model/messages.js" */

const MAGIC = 0x53;
const VERSION = 2;
const HEADER_BYTES = 16;
const FLIGHT_BYTES = 18;
const CURVE_BYTES = 26;
const STEPS = 1024; // units in a tick, in which a segment's age is sent
const GRID = 65535;
const FULL = 1;

/**
 * Converts the numbers of a message to SI units; all values follow from the hello.
 * @typedef {object} SegmentScale
 * @property {Extent} extent metres
 * @property {number} velocityScale m/s for one unit of a snapshot's velocity, or two units of a segment's
 * @property {number} spinScale rad/s for one unit of a segment's spin
 * @property {number} rate ticks a second
 */

/**
 * @param {ArrayBuffer} buffer
 * @param {SegmentScale} scale
 * @returns {SegmentMessage}
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
      readSegment(view, HEADER_BYTES + i * FLIGHT_BYTES, tick, scale)),
    curves: Array.from({ length: curves }, (_, i) => {
      const at = middle + i * CURVE_BYTES;
      const bend = { ax: view.getFloat32(at + 18, true), ay: view.getFloat32(at + 22, true) };
      return { ...readSegment(view, at, tick, scale), bend };
    }),
  };
}

/**
 * @param {DataView} view
 * @param {number} at byte
 * @param {number} tick of the message
 * @param {SegmentScale} scale
 * @returns {Segment}
 */
function readSegment(view, at, tick, { extent, velocityScale, spinScale, rate }) {
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

/** @param {DataView} view @returns {{flights: number, curves: number}} how many of each follow */
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
