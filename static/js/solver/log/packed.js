// MessagePack as the engine writes a world's state, each value in its shortest form.

import { Bytes, utf8 } from "../encoding/bytes.js";

export class Packed {
  #out = new Bytes();

  /** @returns {Uint8Array} all bytes written until now */
  get written() {
    return this.#out.written;
  }

  nothing() {
    this.#out.bytes([0xc0]);
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
