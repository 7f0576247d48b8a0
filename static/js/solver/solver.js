// The exact solver for pages: computes drops from a board's JSON, bit for bit as the server does.
//
//   import { openSolver } from "./solver/solver.js";
//   const solver = await openSolver();
//   const drop = solver.drop(board, { seed: "42" });   // or { seed: "42", aim: 0.01 }, or { x: 0.1 }
//   drop.bin, drop.digest, drop.impacts, drop.states([0, 0.5]), drop.record()
//
// It needs only this folder and a JavaScript engine with WebAssembly.

import { shownJson } from "./input/json-text.js";
import { readBoard } from "./input/values.js";
import { bytesOf } from "./encoding/beside.js";
import { boardDigest } from "./digest.js";
import { Drop } from "./drop.js";
import { Kernels } from "./kernels.js";
import { seedOf, startOf, startsOf } from "./seed.js";

const KERNELS = new URL("kernels.wasm", import.meta.url);

/** @import { Binary } from "./machine.js" */
/** @import { WholeBoard } from "./input/values.js" */

/**
 * Where a ball starts: at x (m), or where the seed draws it, around aim (m) or by default around the
 * drop zone's x. If both x and seed are given, the ball starts at x.
 * @typedef {{seed?: string | bigint | number | null, x?: number | null, aim?: number | null}} Start
 */

/**
 * @param {Binary} [bytes] of kernels.wasm; by default loaded from this module's folder
 * @returns {Promise<Solver>}
 */
export async function openSolver(bytes) {
  return new Solver(await Kernels.open(bytes ?? (await bytesOf(KERNELS))));
}

/** Computes drops; made by `openSolver`. */
export class Solver {
  #kernels;
  /** The last board that was read. @type {{text: string, ready: Ready} | null} */
  #last = null;
  /** The board that the kernels have loaded. @type {Ready | null} */
  #loaded = null;

  /** @param {Kernels} kernels */
  constructor(kernels) {
    this.#kernels = kernels;
  }

  /**
   * Checks a board and fills in its defaults. `drop` does not check the returned object again.
   * @param {unknown} form the board's JSON, parsed; throws a BoardError that names an invalid value
   * @returns {WholeBoard}
   */
  read(form) {
    return this.#ready(form).board;
  }

  /**
   * Computes the drop of a ball that starts at rest.
   * @param {unknown} form the board's JSON, parsed; throws a BoardError that names an invalid value
   * @param {Start} start throws a ParameterError that names an invalid value
   * @returns {Drop}
   */
  drop(form, start) {
    const ready = this.#load(this.#ready(form));
    const { board, digest } = ready;
    const seed = start.seed === null || start.seed === undefined ? null : seedOf(start.seed);
    const { x, explicit, aim } = startOf(board.drop, seed, start);
    const traced = this.#kernels.trace(x, board.drop.y);
    return new Drop({ board, digest, seed, x, explicit, aim, traced }, (times) => {
      this.#load(ready);
      return this.#kernels.sample(traced.segments, times);
    });
  }

  /**
   * Computes how many drops end. Their paths are not kept, which is faster than `drop`.
   * @param {unknown} form the board's JSON, parsed
   * @param {Iterable<string | bigint | number>} seeds
   * @param {number | null} [aim] m, the same for all
   * @returns {ReturnType<Kernels["traceMany"]>} arrays in the order of the seeds; bin -1: not landed
   */
  dropMany(form, seeds, aim = null) {
    const { board } = this.#load(this.#ready(form));
    return this.#kernels.traceMany(startsOf(board.drop, seeds, aim), board.drop.y);
  }

  /** @param {unknown} form @returns {Ready} */
  #ready(form) {
    const last = this.#last;
    if (last && last.ready.board === form) return last.ready;
    const text = shownJson(form);
    if (last && last.text === text) return last.ready;
    const board = readBoard(form);
    const ready = { board, digest: boardDigest(board) };
    this.#last = { text, ready };
    return ready;
  }

  /** @param {Ready} ready */
  #load(ready) {
    if (ready !== this.#loaded) this.#kernels.load(ready.board);
    this.#loaded = ready;
    return ready;
  }
}

/** @typedef {{board: WholeBoard, digest: string}} Ready a board that was read */
