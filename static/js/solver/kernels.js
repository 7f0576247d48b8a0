// Calls the kernels of the exact solver on one board at a time.

import { floats, Machine } from "./machine.js";

/** @import { Material } from "../model/board.js" */
/** @import { WholeBoard } from "./input/values.js" */
/** @import { Binary, Kind, Value } from "./machine.js" */

/**
 * The path of one ball, as the kernels computed it.
 * @typedef {object} Traced
 * @property {number} outcome 0 if it landed; otherwise an index of REASONS in drop.js
 * @property {number} bin -1 if it did not land
 * @property {number[]} end its last state: t, x, y, vx, vy, theta, omega
 * @property {number[][]} impacts each: t, x, y, vx, vy, omega right after it, kind, number of the surface
 * @property {Float64Array} segments rows of SEGMENT columns, from which `sample` computes states
 */

const MODULE = "plinko.engine.exact.";
const STATE = 7; // columns
const EVENT = 6;
const SEGMENT = 11;
const SERIES = [8, 21]; // the shape of the work space
const START = [-1n, 0n, -1n, 0n, 0n, 0n, 0n, -1n]; // the phase of a ball at the start of its drop
const MAX_EVENTS = 100_000;
const MAX_TIME = 1000; // s
const ROOM = 256; // events in the first log; a longer drop is traced again with a log of its size

/** An instance of the kernels, made by `open`. */
export class Kernels {
  #machine;
  /** @type {Value[]} */
  #board = [];

  /** @param {Machine} machine */
  constructor(machine) {
    this.#machine = machine;
  }

  /** @param {Binary} bytes of kernels.wasm @returns {Promise<Kernels>} */
  static async open(bytes) {
    return new Kernels(await Machine.open(bytes));
  }

  /** Selects the board of all later calls. @param {WholeBoard} board */
  load(board) {
    const { pegs, walls, ball, bins, gravity, drag } = board;
    this.#machine.release();
    const arrays = this.#machine.run(`${MODULE}board_arrays.lay_out_board`, [
      floats(pegs.flatMap(({ x, y, radius }) => [x, y, radius]), pegs.length, 3),
      floats(walls.flatMap(({ x1, y1, x2, y2 }) => [x1, y1, x2, y2]), walls.length, 4),
      floats(bins.edges, bins.edges.length), bins.y, gravity, drag, ball.radius,
      ...combined(ball, board.peg_material), ...combined(ball, board.wall_material),
    ]);
    this.#board = arrays.map((value) => (typeof value === "object" ? this.#machine.keep(value) : value));
  }

  /** @param {number} x m @param {number} y m @returns {Traced} the path of a ball that starts at rest */
  trace(x, y) {
    let room = { events: ROOM, segments: 4 * ROOM };
    for (;;) {
      const { counts, read } = this.#run([x], y, room.events, room.segments);
      const [events, segments] = [Number(counts[0]), Number(counts[1])];
      if (events <= room.events && segments <= room.segments) {
        const marks = read("marks");
        return {
          outcome: read("outcomes")[0],
          bin: read("bins")[0],
          end: Array.from(read("states")),
          impacts: rowsOf(read("events").subarray(0, EVENT * events), EVENT)
            .map((row, i) => [...row, marks[2 * i], marks[2 * i + 1]]),
          segments: read("segments").slice(0, SEGMENT * segments),
        };
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
    const { read } = this.#run(xs, y, 0, 0);
    const states = read("states");
    return {
      bins: read("bins").slice(),
      impacts: read("impacts").slice(),
      outcomes: read("outcomes").slice(),
      durations: Float64Array.from({ length: xs.length }, (_, i) => states[STATE * i]),
      xEnds: Float64Array.from({ length: xs.length }, (_, i) => states[STATE * i + 1]),
    };
  }

  /**
   * States of a drop that was traced on the loaded board.
   * @param {Float64Array} segments
   * @param {number[]} times s, from its start to its end
   * @returns {number[][]} t, x, y, vx, vy, theta, omega at each time
   */
  sample(segments, times) {
    const [machine, count] = [this.#machine, times.length];
    const rows = BigInt64Array.from(times, (time) => BigInt(rowAt(segments, time)));
    const end = machine.end;
    const out = machine.reserve("f8", [count, STATE]);
    machine.run(`${MODULE}sampling.sample`, [
      ...this.#board, machine.keep({ values: segments, shape: [segments.length / SEGMENT, SEGMENT] }),
      machine.keep({ values: rows, shape: [count] }),
      machine.keep({ values: rows.map((row) => row + 1n), shape: [count] }),
      machine.keep(floats(times, count)), false, machine.reserve("f8", SERIES), out,
    ]);
    machine.release(end);
    return rowsOf(/** @type {Float64Array} */ (machine.view(out)), STATE);
  }

  /**
   * @param {ArrayLike<number>} xs
   * @param {number} y
   * @param {number} eventRoom rows of the log
   * @param {number} segmentRoom rows of the log
   */
  #run(xs, y, eventRoom, segmentRoom) {
    const machine = this.#machine;
    const count = xs.length;
    const end = machine.end;
    /** @type {Record<string, [Kind, ...number[]]>} in the order of the kernel's arguments */
    const kinds = {
      states: ["f8", count, STATE], initial: ["i8", count, START.length], series: ["f8", ...SERIES],
      events: ["f8", eventRoom, EVENT], marks: ["i4", eventRoom, 2], segments: ["f8", segmentRoom, SEGMENT],
      counts: ["i8", 3], ends: ["i8", 0, 3], outcomes: ["i1", count], bins: ["i4", count],
      impacts: ["i4", count],
    };
    const placed = Object.fromEntries(Object.entries(kinds).map(([name, [of, ...shape]]) =>
      [name, machine.reserve(of, shape)]));
    /** @param {string} name @returns {any} */
    const read = (name) => machine.view(placed[name]);
    const [states, initial] = [read("states").fill(0), read("initial")];
    read("counts").fill(0n);
    for (let i = 0; i < count; i += 1) {
      states.set([xs[i], y], STATE * i + 1);
      initial.set(START, START.length * i);
    }
    const { states: first, initial: phases, ...others } = placed;
    machine.run(`${MODULE}trace.trace_many`, [
      ...this.#board, first, phases, MAX_EVENTS, MAX_TIME, ...Object.values(others),
    ]);
    machine.release(end);
    return { counts: read("counts"), read };
  }
}

/** @param {Material} a @param {Material} b @returns {[number, number]} restitution and friction */
function combined(a, b) {
  return [Math.max(a.restitution, b.restitution), Math.sqrt(a.friction * b.friction)];
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
