// Runs the engine's kernels, compiled to WebAssembly, with arguments in memory.
//
// The layout is that of numba's code, as in engine/jit/calls.py. The block of a call has eight bytes for
// each number. For an array these numbers are: two addresses that are not used here, the count of values,
// the bytes of a value, the address of the values, the shape, and the strides. The results follow. The
// module names its kernels' types: "f8" for a number, "f8:2" for an array of two dimensions.

const KINDS = {
  f8: Float64Array, i8: BigInt64Array, i4: Int32Array, u4: Uint32Array, i1: Int8Array,
};

/** @typedef {keyof KINDS} Kind */
/** @typedef {Float64Array | BigInt64Array | Int32Array | Uint32Array | Int8Array} Values */

/**
 * A contiguous array, which is copied for a call.
 * @template {Values} [T=Values]
 * @typedef {{values: T, shape: number[]}} Grid
 */

/** @typedef {{of: Kind, shape: number[], at: number}} Placed an array that stays in the memory */
/** @typedef {number | boolean | Grid | Placed} Value */
/** @typedef {{takes: string[], gives: string[]}} Signature */

/**
 * WebAssembly's types as far as they are used here. Their own names need the types of a page.
 * @typedef {ArrayBuffer | ArrayBufferView<ArrayBuffer>} Binary
 * @typedef {{readonly buffer: ArrayBuffer, grow: (pages: number) => number}} Memory
 */

const PAGE = 65_536; // bytes that memory grows by
const BLOCK = 4 * PAGE; // address of a call's block, where LLVM's stack ends
const ARRAYS = BLOCK + PAGE; // address of the first array; a block and its results are shorter
const HEAP = 8; // address of the pointer to memory for arrays that kernels allocate
const STATUS = 16; // address of a call's status
const FINE = [0, -2]; // numba's status codes of success: with a result, and with None
const OWN_ADDRESS = 24; // offset in bytes, in a returned array
const SHAPE = 32;

/** An instance of the kernels with its memory. */
export class Machine {
  #exports;
  #memory;
  #calls;
  #free = ARRAYS;

  /**
   * @param {Record<string, unknown>} exports @param {Memory} memory
   * @param {Record<string, Signature>} calls
   */
  constructor(exports, memory, calls) {
    this.#exports = exports;
    this.#memory = memory;
    this.#calls = calls;
  }

  /** @param {Binary} bytes of the module @returns {Promise<Machine>} */
  static async open(bytes) {
    const module = await WebAssembly.compile(bytes);
    const [described] = WebAssembly.Module.customSections(module, "plinko");
    const { calls } = JSON.parse(String.fromCharCode(...new Uint8Array(described)));
    const memory = new WebAssembly.Memory({ initial: 6 });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, BLOCK);
    const env = { __linear_memory: memory, __stack_pointer: stack };
    const { exports } = await WebAssembly.instantiate(module, { env });
    return new Machine(exports, memory, calls);
  }

  /**
   * Runs a kernel and returns its results. Arrays that the kernel changes are changed here too.
   * @param {string} name of the kernel, with its module
   * @param {Value[]} values its arguments, in order; the parts of a tuple one after another
   * @returns {any[]} a number, a boolean or a Grid each
   */
  run(name, values) {
    const { takes, gives } = this.#calls[name];
    const begin = this.#free;
    const placed = values.map((value) => (isGrid(value) ? this.keep(value) : value));
    const results = this.#fill(takes, placed);
    new DataView(this.#memory.buffer).setUint32(HEAP, this.#free, true);
    this.#free = begin;
    const call = /** @type {() => void} */ (this.#exports[name]);
    call();
    const status = new DataView(this.#memory.buffer).getInt32(STATUS, true);
    if (!FINE.includes(status)) throw new Error(`${name} ended with numba's code ${status}`);
    values.forEach((value, i) => {
      if (isGrid(value)) value.values.set(/** @type {any} */ (this.view(/** @type {Placed} */ (placed[i]))));
    });
    return this.#results(gives, results);
  }

  /** Places an array in the memory, where it stays until `release`. @param {Grid} grid @returns {Placed} */
  keep({ values, shape }) {
    const of = /** @type {Kind} */ (Object.keys(KINDS).find((kind) =>
      values instanceof KINDS[/** @type {Kind} */ (kind)]));
    const placed = this.reserve(of, shape);
    this.view(placed).set(/** @type {any} */ (values));
    return placed;
  }

  /** Places an array with any values in the memory. @param {Kind} of @param {number[]} shape @returns {Placed} */
  reserve(of, shape) {
    const at = this.#free;
    this.#free += 8 * Math.ceil((product(shape) * KINDS[of].BYTES_PER_ELEMENT) / 8);
    const lacking = this.#free - this.#memory.buffer.byteLength;
    if (lacking > 0) this.#memory.grow(Math.ceil(lacking / PAGE));
    return { of, shape, at };
  }

  /** The values of an array in the memory, until that grows. @param {Placed} placed @returns {Values} */
  view({ of, shape, at }) {
    return new KINDS[of](this.#memory.buffer, at, product(shape));
  }

  /** The end of all arrays in the memory, for `release`. */
  get end() {
    return this.#free;
  }

  /** Forgets all arrays that were placed since the memory ended there. @param {number} [end] */
  release(end = ARRAYS) {
    this.#free = end;
  }

  /**
   * @param {string[]} takes @param {Value[]} values
   * @returns {number} the address of the results
   */
  #fill(takes, values) {
    const view = new DataView(this.#memory.buffer);
    let at = BLOCK;
    /** @param {number} number */
    const word = (number) => {
      view.setUint32(at, number >>> 0, true);
      view.setInt32(at + 4, Math.floor(number / 2 ** 32), true);
      at += 8;
    };
    values.forEach((value, i) => {
      if (typeof value === "object") {
        const { of, shape, at: address } = /** @type {Placed} */ (value);
        const bytes = KINDS[of].BYTES_PER_ELEMENT;
        for (const number of [0, 0, product(shape), bytes, address, ...shape]) word(number);
        for (const stride of stridesOf(shape, bytes)) word(stride);
      } else if (takes[i] === "f8") {
        view.setFloat64(at, Number(value), true);
        at += 8;
      } else word(Number(value));
    });
    return at;
  }

  /** @param {string[]} gives @param {number} at */
  #results(gives, at) {
    const view = new DataView(this.#memory.buffer);
    return gives.map((given) => {
      const [kind, dimensions] = given.split(":");
      const from = at;
      at += dimensions ? SHAPE + 16 * Number(dimensions) : 8;
      if (dimensions) return this.#arrayAt(from, /** @type {Kind} */ (kind), Number(dimensions));
      if (kind === "f8") return view.getFloat64(from, true);
      if (kind === "i8") return Number(view.getBigInt64(from, true));
      return view.getUint8(from) !== 0;
    });
  }

  /** @param {number} at @param {Kind} of @param {number} dimensions @returns {Grid} a copy */
  #arrayAt(at, of, dimensions) {
    const view = new DataView(this.#memory.buffer);
    const shape = Array.from({ length: dimensions }, (_, i) =>
      Number(view.getBigInt64(at + SHAPE + 8 * i, true)));
    const address = product(shape) ? view.getUint32(at + OWN_ADDRESS, true) : 0;
    return { values: this.view({ of, shape, at: address }).slice(), shape };
  }
}

/** @param {ArrayLike<number>} values @param {...number} shape @returns {Grid<Float64Array>} */
export function floats(values, ...shape) {
  return { values: Float64Array.from(values), shape };
}

/** @param {Value} value @returns {value is Grid} */
function isGrid(value) {
  return typeof value === "object" && "values" in value;
}

/** @param {number[]} shape @param {number} bytes of a value @returns {number[]} bytes */
function stridesOf(shape, bytes) {
  return shape.map((_, i) => bytes * product(shape.slice(i + 1)));
}

/** @param {number[]} sides */
function product(sides) {
  return sides.reduce((one, other) => one * other, 1);
}
