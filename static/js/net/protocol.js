// Decodes the server's messages: snapshots (bytes) and events (JSON). Pure.

/** @import { Extent, Snapshot } from "../model/messages.js" */

export const PROTOCOL = 2;
const MAGIC = 0x50;
const VERSION = 1;
const HEADER_BYTES = 12;
const BALL_BYTES = 12;
const GRID = 65535; // steps of a coordinate across the extent
const BOUNCED = 1;
const ASLEEP = 2;

/** A message does not follow the protocol. */
export class ProtocolError extends Error {}

/**
 * Converts quantised numbers to SI units; both values are in the hello.
 * @typedef {object} SnapshotScale
 * @property {Extent} extent metres
 * @property {number} velocityScale m/s of one velocity step
 */

/**
 * @param {ArrayBuffer} buffer
 * @param {SnapshotScale} scale
 * @param {number} near a tick less than 2^31 away: the message has only the last 32 bits of its own
 * @returns {Snapshot}
 */
export function decodeSnapshot(buffer, { extent, velocityScale }, near) {
  const view = new DataView(buffer);
  const count = checkHeader(view);
  // The operations have the order of the server's decoder, so that both give the same bits.
  const across = extent.x_max - extent.x_min;
  const down = extent.y_max - extent.y_min;
  const balls = Array.from({ length: count }, (_, i) => {
    const at = HEADER_BYTES + i * BALL_BYTES;
    const flags = view.getUint8(at + 7);
    return {
      id: view.getUint16(at, true),
      x: (view.getUint16(at + 2, true) / GRID) * across + extent.x_min,
      y: (view.getUint16(at + 4, true) / GRID) * down + extent.y_min,
      angle: view.getUint8(at + 6) * ((2 * Math.PI) / 256),
      bounced: (flags & BOUNCED) !== 0,
      asleep: (flags & ASLEEP) !== 0,
      vx: view.getInt16(at + 8, true) * velocityScale,
      vy: view.getInt16(at + 10, true) * velocityScale,
    };
  });
  return { tick: near + ((view.getUint32(4, true) - near) | 0), seq: view.getUint32(8, true), balls };
}

/** @param {DataView} view @returns {number} how many balls follow */
function checkHeader(view) {
  if (view.byteLength < HEADER_BYTES) {
    throw new ProtocolError(`snapshot of ${view.byteLength} bytes is shorter than its header`);
  }
  if (view.getUint8(0) !== MAGIC) {
    throw new ProtocolError(`snapshot starts with ${view.getUint8(0)}, not ${MAGIC}`);
  }
  if (view.getUint8(1) !== VERSION) {
    throw new ProtocolError(`snapshot version ${view.getUint8(1)} is not ${VERSION}`);
  }
  const count = view.getUint16(2, true);
  const expected = HEADER_BYTES + count * BALL_BYTES;
  if (view.byteLength !== expected) {
    throw new ProtocolError(
      `snapshot of ${count} balls has ${view.byteLength} bytes, not ${expected}`,
    );
  }
  return count;
}

/**
 * Decodes events. Only their types are checked: the page trusts the server to send all fields.
 * @template {{type: string}} Message
 * @param {string} text one message, or the array of a tick's messages
 * @returns {Message[]} in the order they happened
 */
export function decodeEvents(text) {
  /** @type {unknown} */
  let data;
  try {
    data = JSON.parse(text);
  } catch (cause) {
    throw new ProtocolError(`event is not JSON: ${text.slice(0, 80)}`, { cause });
  }
  /** @type {({type?: unknown, protocol?: unknown} | null)[]} */
  const events = Array.isArray(data) ? data : [data];
  for (const event of events) {
    if (typeof event?.type !== "string") {
      throw new ProtocolError(`event has no type: ${text.slice(0, 80)}`);
    }
    if (event.type === "hello" && event.protocol !== PROTOCOL) {
      throw new ProtocolError(`the server speaks protocol ${event.protocol}, not ${PROTOCOL}`);
    }
  }
  return /** @type {Message[]} */ (events);
}
