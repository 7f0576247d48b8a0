// Whether this page computes the paths of a room's balls, and how.

import { SEEDS } from "../net/streams.js";
import { PHYSICS_VERSION } from "../solver/digest.js";
import { BoardError } from "../solver/errors.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Solve } from "../model/table/table.js" */
/** @import { Solver } from "../solver/solver.js" */

/**
 * @param {Solver | null} solver
 * @param {Hello} hello
 * @returns {Solve | null} null where the room is shown otherwise, or this page cannot compute it
 */
export function solveFor(solver, { stream, board, physics_version: version }) {
  if (stream !== SEEDS || !solver || version !== PHYSICS_VERSION) return null;
  try {
    const whole = solver.read(board);
    return (start) => solver.drop(whole, start);
  } catch (error) {
    if (!(error instanceof BoardError)) throw error;
    return null;
  }
}
