// Computes drops in this page: where the server is silent, and where no server is needed. Loaded when it is needed.

import { samplesNeeded } from "../model/motion/drop.js";
import { ApiError } from "../net/api.js";
import { boardDigest } from "../solver/digest.js";
import { BoardError, ParameterError } from "../solver/errors.js";
import { openSolver } from "../solver/solver.js";

/** @import { Board } from "../model/board.js" */
/** @import { DropRecord, Sampled } from "../model/motion/drop.js" */
/** @import { State } from "../model/motion/flight.js" */
/** @import { DropAddress } from "../net/drop-address.js" */

/** This page's solver, null in a browser without WebAssembly. */
const solving = openSolver().catch(() => null);

/**
 * @param {Board} board @param {DropAddress} drop
 * @returns {Promise<{record: DropRecord, sampled: Sampled} | null>} null if this page cannot compute it
 */
export async function computeDrop(board, { seed, x, aim, solver: wanted }) {
  const solver = await solving;
  if (!solver || wanted === "stepped") return null;
  const start = { seed, x: numberIn(x), aim: numberIn(aim) };
  const drop = told(() => solver.drop(board, start));
  const { impacts, duration } = drop;
  const fps = samplesNeeded({ impacts, duration, solver: "exact" });
  const times = Array.from({ length: Math.floor(duration * fps) + 1 }, (_, i) => i / fps);
  if (times[times.length - 1] < duration) times.push(duration);
  const record = /** @type {DropRecord} */ (/** @type {unknown} */ (drop.record()));
  const fields = ["t", "x", "y", "theta", "vx", "vy", "omega"];
  const rows = (/** @type {State[]} */ states) => states.map((state) => Object.values(state));
  return { record, sampled: { fields, frames: rows(drop.states(times)), before: rows(drop.before()) } };
}

/** @param {unknown} form a board's JSON @returns {Promise<{board: Board, address: string} | null>} null without a solver */
export async function readForm(form) {
  const solver = await solving;
  if (!solver) return null;
  const board = told(() => solver.read(form));
  return { board, address: boardDigest(board) };
}

/**
 * Turns the solver's errors into ApiErrors, so that the page shows them like the server's refusals.
 * @template T
 * @param {() => T} compute
 * @returns {T}
 */
function told(compute) {
  try {
    return compute();
  } catch (error) {
    if (!(error instanceof BoardError || error instanceof ParameterError)) throw error;
    throw new ApiError(error.message, 422, { cause: error, field: error.field });
  }
}

/** @param {string | number | null | undefined} text from the address @returns {number | null} */
const numberIn = (text) => (text === null || text === undefined || text === "" ? null : Number(text));
