// Calls the engine's kernels, compiled to WebAssembly, on one board at a time, and manages their memory.

import { COLUMNS } from "./input/surfaces.js";

/** @import { WholeBoard } from "./input/values.js" */

/** @typedef {{floats: Float64Array, words: Uint32Array}} Arrays a board's, from input/arrays.js */

/**
 * The path of one ball, as the kernels computed it.
 * @typedef {object} Traced
 * @property {number} outcome 0 if it landed; otherwise an index of REASONS in drop.js
 * @property {number} bin -1 if it did not land
 * @property {number[]} end its last state: t, x, y, vx, vy, theta, omega
 * @property {number[][]} impacts each: t, x, y, vx, vy, omega right after it, kind, number of the surface
 * @property {Float64Array} segments rows of SEGMENT columns, from which `sample` computes states
 *
 * @typedef {{lay_out: Function, trace: Function, sample: Function}} Exports
 */

const PAGE = 65_536; // bytes that memory grows by
const STACK = PAGE; // bytes below all blocks
const STATE = 7; // columns
const EVENT = 6;
const SEGMENT = 11;
const INITIAL = 8;
const SERIES = 8 * 21; // numbers
const ROOM = 256; // events in the first log; a longer drop is traced again with a log of its size

/** An instance of the kernels with its memory, made by `open`. */
export class Kernels {
  #exports;
  #memory;
  #board = { floats: 0, words: 0 };
  #free = STACK;

  /** @param {Exports} exports @param {WebAssembly.Memory} memory */
  constructor(exports, memory) {
    this.#exports = exports;
    this.#memory = memory;
  }

  /** @param {BufferSource} bytes of kernels.wasm @returns {Promise<Kernels>} */
  static async open(bytes) {
    const memory = new WebAssembly.Memory({ initial: 4 });
    const stack = new WebAssembly.Global({ value: "i32", mutable: true }, STACK);
    const env = { __linear_memory: memory, __stack_pointer: stack };
    const { instance } = await WebAssembly.instantiate(bytes, { env });
    return new Kernels(/** @type {Exports} */ (/** @type {unknown} */ (instance.exports)), memory);
  }

  /**
   * The surfaces of a board.
   * @param {WholeBoard} board
   * @returns {Float64Array} rows of COLUMNS: the pegs, then each wall's line and its two ends
   */
  layOut({ pegs, walls, ball: { radius } }) {
    const count = COLUMNS * (pegs.length + 3 * walls.length);
    const room = new Blocks(this.#memory, this.#free);
    const at = {
      pegs: room.take(24 * pegs.length), walls: room.take(32 * walls.length),
      items: room.take(8 * count),
    };
    room.grow();
    const { buffer } = this.#memory;
    new Float64Array(buffer, at.pegs).set(pegs.flatMap((peg) => [peg.x, peg.y, peg.radius]));
    new Float64Array(buffer, at.walls).set(walls.flatMap(({ x1, y1, x2, y2 }) => [x1, y1, x2, y2]));
    const items = new Float64Array(buffer, at.items, count).fill(0);
    this.#exports.lay_out(at.pegs, pegs.length, at.walls, walls.length, radius, at.items);
    return items.slice();
  }

  /** Selects the board of all later calls. @param {Arrays} arrays */
  load({ floats, words }) {
    const room = new Blocks(this.#memory, STACK);
    this.#board = { floats: room.take(floats.byteLength), words: room.take(words.byteLength) };
    this.#free = room.at;
    room.grow();
    new Float64Array(this.#memory.buffer, this.#board.floats).set(floats);
    new Uint32Array(this.#memory.buffer, this.#board.words).set(words);
  }

  /** @param {number} x m @param {number} y m @returns {Traced} the path of a ball that starts at rest */
  trace(x, y) {
    let room = { events: ROOM, segments: 4 * ROOM };
    for (;;) {
      const { at, counts } = this.#run([x], y, room.events, room.segments);
      const [events, , segments] = counts;
      if (events <= room.events && segments <= room.segments) {
        return this.#traced(at, events, segments);
      }
      room = { events: Math.max(events, room.events), segments: Math.max(segments, room.segments) };
    }
  }

  /**
   * How many drops end; their paths are not kept.
   * @param {ArrayLike<number>} xs m
   * @param {number} y m
   * @returns {{bins: Int32Array, impacts: Int32Array, outcomes: Int8Array, durations: Float64Array,
   *   xEnds: Float64Array}}
   */
  traceMany(xs, y) {
    const count = xs.length;
    const { at } = this.#run(xs, y, 0, 0);
    const { buffer } = this.#memory;
    const states = new Float64Array(buffer, at.states, STATE * count);
    return {
      bins: new Int32Array(buffer, at.ends, count).slice(),
      impacts: new Int32Array(buffer, at.ends + 4 * count, count).slice(),
      outcomes: new Int8Array(buffer, at.outcomes, count).slice(),
      durations: Float64Array.from({ length: count }, (_, i) => states[STATE * i]),
      xEnds: Float64Array.from({ length: count }, (_, i) => states[STATE * i + 1]),
    };
  }

  /**
   * States of a drop that was traced on the loaded board.
   * @param {Float64Array} segments
   * @param {number[]} times s, from its start to its end
   * @returns {number[][]} t, x, y, vx, vy, theta, omega at each time
   */
  sample(segments, times) {
    const count = times.length;
    const room = new Blocks(this.#memory, this.#free);
    const at = {
      segments: room.take(segments.byteLength), rows: room.take(16 * count),
      times: room.take(8 * count), series: room.take(8 * SERIES), out: room.take(8 * STATE * count),
    };
    room.grow();
    const { buffer } = this.#memory;
    new Float64Array(buffer, at.segments).set(segments);
    new Float64Array(buffer, at.times).set(times);
    const rows = new Int32Array(buffer, at.rows, 4 * count).fill(0); // the low halves of 64 bits
    times.forEach((time, i) => {
      const row = rowAt(segments, time);
      rows[2 * i] = row;
      rows[2 * (count + i)] = row + 1;
    });
    const { floats, words } = this.#board;
    this.#exports.sample(floats, words, at.segments, segments.length / SEGMENT, at.rows, at.times,
      count, at.series, at.out);
    return rowsOf(new Float64Array(buffer, at.out, STATE * count), STATE);
  }

  /**
   * @param {ArrayLike<number>} xs
   * @param {number} y
   * @param {number} events rows of the log
   * @param {number} segments rows of the log
   */
  #run(xs, y, events, segments) {
    const count = xs.length;
    const room = new Blocks(this.#memory, this.#free);
    const at = {
      states: room.take(8 * STATE * count), initial: room.take(8 * INITIAL * count),
      events: room.take(8 * EVENT * events), marks: room.take(8 * events),
      segments: room.take(8 * SEGMENT * segments), counts: room.take(24),
      ends: room.take(8 * count), outcomes: room.take(count), series: room.take(8 * SERIES),
    };
    room.grow();
    const { buffer } = this.#memory;
    const states = new Float64Array(buffer, at.states, STATE * count).fill(0);
    for (let i = 0; i < count; i += 1) {
      states[STATE * i + 1] = xs[i];
      states[STATE * i + 2] = y;
    }
    const counts = new Int32Array(buffer, at.counts, 6).fill(0);
    const { floats, words } = this.#board;
    this.#exports.trace(floats, words, count, at.states, at.initial, at.events, at.marks, events,
      at.segments, segments, at.counts, at.ends, at.outcomes, at.series);
    return { at, counts };
  }

  /**
   * @param {{states: number, events: number, marks: number, segments: number, ends: number,
   *   outcomes: number}} at
   * @param {number} events
   * @param {number} segments
   * @returns {Traced}
   */
  #traced(at, events, segments) {
    const { buffer } = this.#memory;
    const marks = new Int32Array(buffer, at.marks, 2 * events);
    return {
      outcome: new Int8Array(buffer, at.outcomes, 1)[0],
      bin: new Int32Array(buffer, at.ends, 1)[0],
      end: Array.from(new Float64Array(buffer, at.states, STATE)),
      impacts: rowsOf(new Float64Array(buffer, at.events, EVENT * events), EVENT)
        .map((row, i) => [...row, marks[2 * i], marks[2 * i + 1]]),
      segments: new Float64Array(buffer, at.segments, SEGMENT * segments).slice(),
    };
  }
}

/** Allocates blocks of memory one after the other. */
class Blocks {
  /** @param {WebAssembly.Memory} memory @param {number} at bytes */
  constructor(memory, at) {
    this.memory = memory;
    this.at = at;
  }

  /** @param {number} bytes @returns {number} address of the block */
  take(bytes) {
    const at = this.at;
    this.at += 8 * Math.ceil(bytes / 8);
    return at;
  }

  /** Grows the memory so that it contains all blocks. */
  grow() {
    const lacking = this.at - this.memory.buffer.byteLength;
    if (lacking > 0) this.memory.grow(Math.ceil(lacking / PAGE));
  }
}

/** @param {Float64Array} values @param {number} columns @returns {number[][]} */
function rowsOf(values, columns) {
  return Array.from({ length: values.length / columns }, (_, i) =>
    Array.from(values.subarray(columns * i, columns * (i + 1))));
}

/** @param {Float64Array} segments @param {number} time @returns {number} the segment at that time */
function rowAt(segments, time) {
  let [low, high] = [0, segments.length / SEGMENT];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (segments[SEGMENT * middle] <= time) low = middle;
    else high = middle;
  }
  return low;
}
