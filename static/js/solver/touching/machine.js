// Runs the engine's kernels for balls that touch: WebAssembly that is called with blocks of memory.
//
// The layout is that of numba's code, as engine/jit/calls.py has it: a call's block has eight bytes
// for each number that the code takes; of an array two addresses that are not used here, its counts
// of values and of bytes in each, its own address, shape and strides. The results are behind it.

import { bytesOf } from "../encoding/beside.js";

/**
 * An array without gaps. bytes: of a value, where it is of 64 bits that are given as two of 32.
 * @template {Float64Array | Int32Array} [T=Float64Array | Int32Array]
 * @typedef {{values: T, shape: number[], bytes?: number}} Grid
 */

/** @typedef {{kind: "array", of: "f8" | "i4", dimensions: number}} GivenArray */
/** @typedef {{kind: "f8"} | {kind: "i8"} | {kind: "b1"} | GivenArray} Given what a kernel returns */

/** @typedef {number | bigint | Grid} Value a float, a whole number or an array */

const PAGE = 65_536; // bytes that memory grows by
const BLOCK = 4 * PAGE; // where a call's block begins, and LLVM's stack ends
const HEAP = 8; // where it stands where the arrays begin that kernels make themselves
const STATUS = 16; // where it stands how a call ended
const FINE = [0, -2]; // of numba's codes: a result, or none
const ARRAY = 5; // numbers of an array ahead of its shape and strides
const OWN_ADDRESS = 24; // bytes, in an array that is returned
const SHAPE = 32;

const KERNELS = new URL("touching.wasm", import.meta.url);

/**
 * @param {BufferSource} [bytes] of touching.wasm; without them it is read from beside this module
 * @returns {Promise<Machine>}
 */
export async function loadMachine(bytes) {
  return Machine.open(bytes ?? (await bytesOf(KERNELS)));
}

/** Memory, and the code that works on it. */
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
   * The kernel's results, one by one; what it was given is written to where it writes to it.
   * @param {string} name of the kernel, with its module
   * @param {Value[]} values all that it takes, in order
   * @param {Given[]} gives all that it gives
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
    const view = new DataView(this.#memory.buffer); // it may have grown
    const status = view.getInt32(STATUS, true);
    if (!FINE.includes(status)) throw new Error(`${name} ended with numba's code ${status}`);
    grids.forEach(({ values: own }, i) => own.set(viewOf(own, this.#memory.buffer, places[i])));
    return this.#results(gives, results);
  }

  /**
   * @param {Grid[]} grids @param {number} begin
   * @returns {number[]} where each is; the kernels' own arrays begin behind the last
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

  /** @param {Value[]} values @param {number[]} places of the arrays among them */
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

/** @param {Value} value @returns {number} numbers of it in a block */
function sizeOf(value) {
  return typeof value === "object" ? ARRAY + 2 * value.shape.length : 1;
}

/** @param {Given} given @returns {number} bytes of it behind a block */
function roomOf(given) {
  return given.kind === "array" ? SHAPE + 16 * given.dimensions : 8;
}

/**
 * Memory as values of an array's type.
 * @param {Float64Array | Int32Array} like @param {ArrayBuffer} buffer @param {number} at
 */
function viewOf(like, buffer, at) {
  return like instanceof Float64Array
    ? new Float64Array(buffer, at, like.length) : new Int32Array(buffer, at, like.length);
}

/** @param {number[]} shape @param {number} bytes of a value @returns {number[]} bytes from row to row */
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
