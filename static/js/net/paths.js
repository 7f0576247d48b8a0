// Decodes the binary messages of `?stream=paths` into the knots of each ball's path. Pure.

import { KNOT } from "../model/motion/flight-path.js";
import { ProtocolError } from "./protocol.js";

/** @import { PathPart } from "../model/messages.js" */

const MAGIC = 0x46;
const VERSION = 1;
const HEADER_BYTES = 16;

/** @param {ArrayBuffer} buffer @returns {PathPart[]} */
export function decodePaths(buffer) {
  const view = new DataView(buffer);
  const parts = [];
  let at = 0;
  do {
    const count = checkHeader(view, at);
    const ball = Number(view.getBigUint64(at + 8, true));
    parts.push({ ball, knots: new Float32Array(buffer, at + HEADER_BYTES, KNOT * count) });
    at += HEADER_BYTES + 4 * KNOT * count;
  } while (at < view.byteLength);
  return parts;
}

/** @param {DataView} view @param {number} at where the header begins @returns {number} how many knots follow */
function checkHeader(view, at) {
  const rest = view.byteLength - at;
  if (rest < HEADER_BYTES) {
    throw new ProtocolError(`a path of ${rest} bytes is shorter than its header`);
  }
  if (view.getUint8(at) !== MAGIC) {
    throw new ProtocolError(`a path starts with ${view.getUint8(at)}, not ${MAGIC}`);
  }
  if (view.getUint8(at + 1) !== VERSION) {
    throw new ProtocolError(`path version ${view.getUint8(at + 1)} is not ${VERSION}`);
  }
  const count = view.getUint32(at + 4, true);
  const size = HEADER_BYTES + 4 * KNOT * count;
  if (count === 0 || rest < size) {
    throw new ProtocolError(`a path of ${count} knots has ${rest} bytes, not ${size}`);
  }
  return count;
}
