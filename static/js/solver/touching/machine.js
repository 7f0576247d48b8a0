// Calls the engine's kernels for touching balls, compiled to WebAssembly, with arguments in memory.
//
// The layout is that of numba's code, as in engine/jit/calls.py. The block of a call has eight bytes for
// each number. For an array these numbers are: two addresses that are not used here, the count of values,
// the bytes of a value, the address of the values, the shape, and the strides. The results follow.

import { bytesOf } from "../encoding/beside.js";

/**
 * A contiguous array. bytes: 8 if each value of 64 bits is given as two of 32.
 * @template {Float64Array | Int32Array} [T=Float64Array | Int32Array]
 * @typedef {{values: T, shape: number[], bytes?: number}} Grid
 */

/** @typedef {{kind: "array", of: "f8" | "i4", dimensions: number}} GivenArray */
/** @typedef {{kind: "f8"} | {kind: "i8"} | {kind: "b1"} | GivenArray} Given the type of a kernel's result */

/** @typedef {number | bigint | Grid} Value a float, a whole number or an array */

const PAGE = 65_536; // bytes that memory grows by
const BLOCK = 4 * PAGE; // address of a call's block, where LLVM's stack ends
const HEAP = 8; // address of the pointer to memory for arrays that kernels allocate
const STATUS = 16; // address of a call's status
const FINE = [0, -2]; // numba's status codes of success: with a result, and with None
const ARRAY = 5; // numbers of an array before its shape and strides
const OWN_ADDRESS = 24; // offset in bytes, in a returned array
const SHAPE = 32;

const KERNELS = new URL("touching.wasm", import.meta.url);

/**
 * @param {BufferSource} [bytes] of touching.wasm; by default loaded from this module's folder
 * @returns {Promise<Machine>}
 */
export async function loadMachine(bytes) {
  return Machine.open(bytes ?? (await bytesOf(KERNELS)));
}

/** An instance of the kernels with its memory. */
export class Machine {
  #exports;
  #memory;

  /** @param {WebAssembly.Exports} exports @param {WebAssembly.Memory} memory */
  constructor(exports, memory) {
    this.#exports = exports;
    this.#memory = memory;
  }

  /** @param {BufferSource} bytes of touching.wasm @returns {Promise<Machine>} */
  static async open(bytes) {
    const memory = new WebAssembly.Memory({ initial: 5 });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, BLOCK);
    const env = { __linear_memory: memory, __stack_pointer: stack };
    const { instance } = await WebAssembly.instantiate(bytes, { env });
    return new Machine(instance.exports, memory);
  }

  /**
   * Runs a kernel and returns its results. Arrays that the kernel changes are changed here too.
   * @param {string} name of the kernel, with its module
   * @param {Value[]} values its arguments, in order
   * @param {Given[]} gives the types of its results
   * @returns {(number | boolean | Grid)[]}
   */
  run(name, values, gives) {
    const results = BLOCK + 8 * total(values.map(sizeOf));
    const begin = results + total(gives.map(roomOf));
    const grids = /** @type {Grid[]} */ (values.filter((value) => typeof value === "object"));
    const places = this.#copyIn(grids, begin);
    this.#fill(values, places);
    const call = /** @type {() => void} */ (this.#exports[name]);
    call();
    const view = new DataView(this.#memory.buffer); // a new buffer, if the call has grown the memory
    const status = view.getInt32(STATUS, true);
    if (!FINE.includes(status)) throw new Error(`${name} ended with numba's code ${status}`);
    grids.forEach(({ values: own }, i) => own.set(viewOf(own, this.#memory.buffer, places[i])));
    return this.#results(gives, results);
  }

  /**
   * @param {Grid[]} grids @param {number} begin
   * @returns {number[]} their addresses; memory after the last one is for arrays that kernels allocate
   */
  #copyIn(grids, begin) {
    let end = begin;
    const places = grids.map(({ values }) => {
      const at = end;
      end += 8 * Math.ceil(values.byteLength / 8);
      return at;
    });
    const lacking = end - this.#memory.buffer.byteLength;
    if (lacking > 0) this.#memory.grow(Math.ceil(lacking / PAGE));
    const { buffer } = this.#memory;
    grids.forEach(({ values }, i) => viewOf(values, buffer, places[i]).set(values));
    new DataView(buffer).setUint32(HEAP, end, true);
    return places;
  }

  /** @param {Value[]} values @param {number[]} places addresses of the arrays among them */
  #fill(values, places) {
    const view = new DataView(this.#memory.buffer);
    let [at, grid] = [BLOCK, 0];
    /** @param {number} number */
    const word = (number) => {
      view.setBigInt64(at, BigInt(number), true);
      at += 8;
    };
    for (const value of values) {
      if (typeof value === "number") {
        view.setFloat64(at, value, true);
        at += 8;
      } else if (typeof value === "bigint") word(Number(value));
      else {
        const { values: own, shape, bytes = own.BYTES_PER_ELEMENT } = value;
        for (const number of [0, 0, product(shape), bytes, places[grid], ...shape]) word(number);
        for (const stride of stridesOf(shape, bytes)) word(stride);
        grid += 1;
      }
    }
  }

  /** @param {Given[]} gives @param {number} at */
  #results(gives, at) {
    const view = new DataView(this.#memory.buffer);
    return gives.map((given) => {
      const from = at;
      at += roomOf(given);
      if (given.kind === "array") return arrayAt(view, from, given);
      if (given.kind === "f8") return view.getFloat64(from, true);
      if (given.kind === "i8") return Number(view.getBigInt64(from, true));
      return view.getUint8(from) !== 0;
    });
  }
}

/** @param {DataView} view @param {number} at @param {GivenArray} given @returns {Grid} a copy */
function arrayAt(view, at, { of, dimensions }) {
  const shape = Array.from({ length: dimensions }, (_, i) =>
    Number(view.getBigInt64(at + SHAPE + 8 * i, true)));
  const length = product(shape);
  const address = length ? view.getUint32(at + OWN_ADDRESS, true) : 0;
  const buffer = /** @type {ArrayBuffer} */ (view.buffer);
  const found = of === "f8"
    ? new Float64Array(buffer, address, length) : new Int32Array(buffer, address, length);
  return { values: found.slice(), shape };
}

/** @param {Value} value @returns {number} how many numbers it has in a block */
function sizeOf(value) {
  return typeof value === "object" ? ARRAY + 2 * value.shape.length : 1;
}

/** @param {Given} given @returns {number} bytes of the result after a block */
function roomOf(given) {
  return given.kind === "array" ? SHAPE + 16 * given.dimensions : 8;
}

/**
 * A view of memory with the type and length of an array.
 * @param {Float64Array | Int32Array} like @param {ArrayBuffer} buffer @param {number} at
 */
function viewOf(like, buffer, at) {
  return like instanceof Float64Array
    ? new Float64Array(buffer, at, like.length) : new Int32Array(buffer, at, like.length);
}

/** @param {number[]} shape @param {number} bytes of a value @returns {number[]} bytes */
function stridesOf(shape, bytes) {
  return shape.map((_, i) => bytes * product(shape.slice(i + 1)));
}

/** @param {number[]} sides */
function product(sides) {
  return sides.reduce((one, other) => one * other, 1);
}

/** @param {number[]} parts */
function total(parts) {
  return parts.reduce((one, other) => one + other, 0);
}
