// The digest of a room's world at a tick, computed from the drops in flight. Pure.

import { Bytes, utf8 } from "../encoding/bytes.js";
import { PHYSICS_VERSION } from "../digest.js";
import { sha256 } from "../encoding/sha256.js";

/** @import { Drop } from "../drop.js" */

const WALL = 1; // the last kind of event that is an impact
const EXACT = Uint8Array.of(0);

/**
 * @typedef {{id: number, seed: string, tick: number, drop: Drop}} Flying tick: of its start
 *
 * @param {{board: string, dt: number, tick: number, dropped: number, flying: Flying[]}} world board: its
 *   digest; dt: s between ticks; dropped: balls until now
 * @returns {string} 64 hexadecimal digits
 */
export function worldDigest({ board, dt, tick, dropped, flying }) {
  const balls = flying.map((ball) => ({ ...ball, ticks: tick - ball.tick }));
  const out = new Packed();
  out.map(11);
  out.text("physics_version");
  out.whole(PHYSICS_VERSION);
  out.text("board_digest");
  out.text(board);
  out.text("solver");
  out.bytes(EXACT);
  out.text("dt");
  out.float(dt);
  out.text("tick");
  out.whole(tick);
  out.text("accumulator");
  out.float(0);
  out.text("next_id");
  out.whole(dropped);
  out.text("balls");
  out.list(balls.length);
  for (const { id, seed, tick: since, drop } of balls) {
    out.list(4);
    out.whole(id);
    out.text(seed);
    out.float(drop.xStart);
    out.whole(since);
  }
  out.text("bounced");
  out.bytes(Uint8Array.from(balls, ({ drop, ticks }) => Number(bounced(drop, ticks, dt))));
  const previous = new Bytes();
  for (const { drop, ticks } of balls) previous.floats(before(drop, ticks, dt));
  out.text("previous");
  out.bytes(previous.written);
  out.text("crowd");
  out.list(balls.length);
  for (const { drop, ticks } of balls) {
    out.map(2);
    out.text("x");
    out.float(drop.xStart);
    out.text("frames");
    out.whole(ticks);
  }
  return sha256(out.written);
}

/** @param {Drop} drop @param {number} ticks @param {number} dt @returns {boolean} whether the ball hit something in the last tick */
function bounced({ impacts }, ticks, dt) {
  const since = ticks > 1 ? (ticks - 1) * dt : -1;
  return impacts.some(([t, , , , , , kind]) => kind <= WALL && t > since && t <= ticks * dt && ticks > 0);
}

/** @param {Drop} drop @param {number} ticks @param {number} dt @returns {number[]} the ball's state one tick ago */
function before(drop, ticks, dt) {
  const [{ t, x, y, vx, vy, theta, omega }] = drop.states([Math.max(0, ticks - 1) * dt]);
  return [t, x, y, vx, vy, theta, omega];
}

/** MessagePack as the engine writes a world's state, each value in its shortest form. */
class Packed {
  #out = new Bytes();

  /** @returns {Uint8Array} all bytes written until now */
  get written() {
    return this.#out.written;
  }

  /** @param {number} value a whole number from 0 to 2^53 - 1 */
  whole(value) {
    if (value < 0x80) this.#out.bytes([value]);
    else this.#sized(value, [[0xcc, 1], [0xcd, 2], [0xce, 4], [0xcf, 8]]);
  }

  /** @param {number} value */
  float(value) {
    const view = new DataView(new ArrayBuffer(8));
    view.setFloat64(0, value);
    this.#out.bytes([0xcb, ...new Uint8Array(view.buffer)]);
  }

  /** @param {string} value */
  text(value) {
    const bytes = utf8(value);
    if (bytes.length < 32) this.#out.bytes([0xa0 + bytes.length]);
    else this.#sized(bytes.length, [[0xd9, 1], [0xda, 2], [0xdb, 4]]);
    this.#out.bytes(bytes);
  }

  /** @param {Uint8Array} value */
  bytes(value) {
    this.#sized(value.length, [[0xc4, 1], [0xc5, 2], [0xc6, 4]]);
    this.#out.bytes(value);
  }

  /** Begins a list, whose values are to be written next. @param {number} length */
  list(length) {
    if (length < 16) this.#out.bytes([0x90 + length]);
    else this.#sized(length, [[0xdc, 2], [0xdd, 4]]);
  }

  /** Begins a map, whose keys and values are to be written next. @param {number} length pairs, below 16 */
  map(length) {
    this.#out.bytes([0x80 + length]);
  }

  /**
   * Writes a number, big-endian, in the first of these forms that is large enough.
   * @param {number} value
   * @param {[number, number][]} forms first byte, and how many bytes follow
   */
  #sized(value, forms) {
    const [mark, size] = forms.find(([, bytes]) => value < 2 ** (8 * bytes)) ?? forms[0];
    const bytes = Array.from({ length: size }, (_, i) => Math.floor(value / 2 ** (8 * (size - 1 - i))));
    this.#out.bytes([mark, ...bytes.map((byte) => byte % 256)]);
  }
}
