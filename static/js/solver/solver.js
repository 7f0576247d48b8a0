// The exact solver in a page: drops from a board's JSON alone, to the server's last bit. One import.
//
//   import { openSolver } from "./solver/solver.js";
//   const solver = await openSolver();
//   const drop = solver.drop(board, { seed: "42" });   // or { seed: "42", aim: 0.01 }, or { x: 0.1 }
//   drop.bin, drop.digest, drop.impacts, drop.states([0, 0.5]), drop.record()
//
// Needs nothing but this folder and an engine with WebAssembly.

import { arraysOf } from "./input/arrays.js";
import { readBoard } from "./input/values.js";
import { bytesOf } from "./encoding/beside.js";
import { boardDigest } from "./digest.js";
import { Drop } from "./drop.js";
import { Kernels } from "./kernels.js";
import { seedOf } from "./seed.js";
import { startOf, startsOf } from "./start.js";

const KERNELS = new URL("kernels.wasm", import.meta.url);

/** @import { WholeBoard } from "./input/values.js" */

/**
 * What decides where a ball starts; x goes before seed, and aim (m) is the middle of what seeds draw.
 * @typedef {{seed?: string | bigint | number | null, x?: number | null, aim?: number | null}} Start
 */

/**
 * @param {BufferSource} [bytes] of kernels.wasm; without them it is read from beside this module
 * @returns {Promise<Solver>}
 */
export async function openSolver(bytes) {
  return new Solver(await Kernels.open(bytes ?? (await bytesOf(KERNELS))));
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
   * Drop a ball at rest from where the seed says, about the board's middle or an aim, or from an x.
   * @param {unknown} form the board's JSON, parsed; throws a BoardError that names a bad value
   * @param {Start} start throws a ParameterError that names a bad value
   * @returns {Drop}
   */
  drop(form, start) {
    const { board, digest } = this.#load(form);
    const seed = start.seed === null || start.seed === undefined ? null : seedOf(start.seed);
    const { x, explicit, aim } = startOf(board.drop, seed, start);
    const traced = this.#kernels.trace(x, board.drop.y);
    return new Drop({ board, digest, seed, x, explicit, aim, traced }, (times) => {
      this.#load(board);
      return this.#kernels.sample(traced.segments, times);
    });
  }

  /**
   * How many drops end, without their paths: as fast as it goes.
   * @param {unknown} form the board's JSON, parsed
   * @param {Iterable<string | bigint | number>} seeds
   * @param {number | null} [aim] m, of them all
   * @returns {ReturnType<Kernels["traceMany"]>} arrays in the order of the seeds; bin -1: none
   */
  dropMany(form, seeds, aim = null) {
    const { board } = this.#load(form);
    return this.#kernels.traceMany(startsOf(board.drop, seeds, aim), board.drop.y);
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
