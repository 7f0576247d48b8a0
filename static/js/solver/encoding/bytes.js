// Numbers as canonical bytes, for digests: little-endian, every NaN as the same quiet NaN.

/** A buffer of bytes that grows as values are appended. */
export class Bytes {
  #view = new DataView(new ArrayBuffer(1024));
  #length = 0;

  /** @returns {Uint8Array} all bytes appended until now */
  get written() {
    return new Uint8Array(this.#view.buffer, 0, this.#length);
  }

  /** @param {number} more bytes to append @returns {number} where they begin */
  #room(more) {
    const at = this.#length;
    this.#length += more;
    if (this.#length > this.#view.byteLength) {
      const larger = new Uint8Array(2 * this.#length);
      larger.set(new Uint8Array(this.#view.buffer));
      this.#view = new DataView(larger.buffer);
    }
    return at;
  }

  /** @param {Iterable<number>} values 0 … 255 */
  bytes(values) {
    for (const value of values) {
      const at = this.#room(1);
      this.#view.setUint8(at, value);
    }
  }

  /** @param {string} hex two digits for each byte */
  hex(hex) {
    this.bytes((hex.match(/../g) ?? []).map((pair) => parseInt(pair, 16)));
  }

  /** Appends text as UTF-8. @param {string} text @returns {number} its bytes */
  text(text) {
    const bytes = utf8(text);
    this.bytes(bytes);
    return bytes.length;
  }

  /** @param {number} value a whole number of 32 bits, signed or unsigned */
  word(value) {
    const at = this.#room(4);
    this.#view.setInt32(at, value, true);
  }

  /** @param {number} value a whole number from 0 to 2^53 - 1, written as 64 bits */
  long(value) {
    const at = this.#room(8);
    this.#view.setBigUint64(at, BigInt(value), true);
  }

  /** @param {Iterable<number>} values */
  floats(values) {
    for (const value of values) {
      const at = this.#room(8);
      if (Number.isNaN(value)) this.#view.setBigUint64(at, 0x7ff8000000000000n, true);
      else this.#view.setFloat64(at, value, true);
    }
  }
}

/** @param {string} text @returns {number[]} its bytes as UTF-8 */
export function utf8(text) {
  const bytes = [];
  for (const letter of text) {
    const code = letter.codePointAt(0) ?? 0;
    if (code < 0x80) bytes.push(code);
    else if (code < 0x800) bytes.push(0xc0 | (code >> 6), 0x80 | (code & 63));
    else if (code < 0x10000) {
      bytes.push(0xe0 | (code >> 12), 0x80 | ((code >> 6) & 63), 0x80 | (code & 63));
    } else {
      bytes.push(0xf0 | (code >> 18), 0x80 | ((code >> 12) & 63), 0x80 | ((code >> 6) & 63),
        0x80 | (code & 63));
    }
  }
  return bytes;
}
