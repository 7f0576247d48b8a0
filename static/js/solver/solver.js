// The exact solver in a page: drops from a board's JSON alone, to the server's last bit. One import.
//
//   import { openSolver } from "./solver/solver.js";
//   const solver = await openSolver();
//   const drop = solver.drop(board, { seed: "42" });   // or { x: 0.1 }
//   drop.bin, drop.digest, drop.impacts, drop.states([0, 0.5]), drop.record()
//
// Needs nothing but this folder and an engine with WebAssembly.

import { arraysOf } from "./input/arrays.js";
import { readBoard } from "./input/values.js";
import { boardDigest } from "./digest.js";
import { Drop } from "./drop.js";
import { ParameterError } from "./errors.js";
import { Kernels } from "./kernels.js";
import { seedOf, startX } from "./seed.js";

/** @import { WholeBoard } from "./input/values.js" */

/** @typedef {{seed?: string | bigint | number | null, x?: number | null}} Start x goes before seed */

/**
 * @param {BufferSource} [bytes] of kernels.wasm; without them it is fetched from beside this module
 * @returns {Promise<Solver>}
 */
export async function openSolver(bytes) {
  return new Solver(await Kernels.open(bytes ?? (await fetchedKernels())));
}

async function fetchedKernels() {
  const url = new URL("kernels.wasm", import.meta.url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href} is not there: ${response.status}`);
  return response.arrayBuffer();
}

/** Drops balls. `openSolver` makes it. */
export class Solver {
  #kernels;
  /** The board used last. @type {{text: string, ready: Ready} | null} */
  #last = null;

  /** @param {Kernels} kernels */
  constructor(kernels) {
    this.#kernels = kernels;
  }

  /**
   * A board with its defaults filled in; given to `drop` as it is, nothing of it is read again.
   * @param {unknown} form the board's JSON, parsed; throws a BoardError that names a bad value
   * @returns {WholeBoard}
   */
  read(form) {
    return this.#load(form).board;
  }

  /**
   * Drop a ball at rest from where the seed says, or from an explicit x.
   * @param {unknown} form the board's JSON, parsed; throws a BoardError that names a bad value
   * @param {Start} start throws a ParameterError that names a bad value
   * @returns {Drop}
   */
  drop(form, start) {
    const { board, digest } = this.#load(form);
    const seed = start.seed === null || start.seed === undefined ? null : seedOf(start.seed);
    const x = startOf(board, seed, start.x);
    const traced = this.#kernels.trace(x, board.drop.y);
    return new Drop({ board, digest, seed, x, explicit: isGiven(start.x), traced }, (times) => {
      this.#load(board);
      return this.#kernels.sample(traced.segments, times);
    });
  }

  /**
   * How many drops end, without their paths: as fast as it goes.
   * @param {unknown} form the board's JSON, parsed
   * @param {Iterable<string | bigint | number>} seeds
   * @returns {ReturnType<Kernels["traceMany"]>} arrays in the order of the seeds; bin -1: none
   */
  dropMany(form, seeds) {
    const { board } = this.#load(form);
    const xs = Float64Array.from(seeds, (seed) => startX(seedOf(seed), board.drop));
    return this.#kernels.traceMany(xs, board.drop.y);
  }

  /** @param {unknown} form @returns {Ready} */
  #load(form) {
    const last = this.#last;
    if (last && last.ready.board === form) return last.ready;
    const text = JSON.stringify(form);
    if (last && last.text === text) return last.ready;
    const board = readBoard(form);
    const ready = { board, digest: boardDigest(board) };
    this.#kernels.load(arraysOf(board));
    this.#last = { text, ready };
    return ready;
  }
}

/** @typedef {{board: WholeBoard, digest: string}} Ready a board that the kernels have */

/** @param {unknown} value */
const isGiven = (value) => value !== null && value !== undefined;

/**
 * @param {WholeBoard} board
 * @param {bigint | null} seed
 * @param {unknown} x
 * @returns {number} where the ball starts, m
 */
function startOf({ drop }, seed, x) {
  if (!isGiven(x)) {
    if (seed !== null) return startX(seed, drop);
    throw new ParameterError("a drop needs a seed or an explicit x", "seed");
  }
  const span = Math.max(drop.jitter, drop.reach);
  const low = Math.min(drop.x - span, ...drop.slots);
  const high = Math.max(drop.x + span, ...drop.slots);
  if (typeof x === "number" && x >= low && x <= high) return x;
  throw new ParameterError(`x ${String(x)} is not a number from ${low} to ${high}`, "x");
}
