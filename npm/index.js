// The package's main module: the solver, drops, and the types that users name.

export { BoardError, ParameterError } from "./solver/errors.js";
export { Drop } from "./solver/drop.js";
export { openSolver, Solver } from "./solver/solver.js";

/**
 * @typedef {import("./model/board.js").Board} Board a board with all its parts; `drop` also takes one without
 *   those that have defaults
 * @typedef {import("./solver/solver.js").Start} Start
 * @typedef {import("./solver/drop.js").BallState} BallState
 */
