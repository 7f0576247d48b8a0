// What the rooms of this device share, where there is no server.

import { MAIN_BOARD, MAIN_ROOM } from "../model/presets.js";
import { openSolver } from "../solver/solver.js";

export const ON_DEVICE = "device-"; // begins the id of each session

/** Computes the results. */
export const solving = openSolver();
solving.catch(() => {}); // a failure is shown when the solver is needed

/** @param {string} room @returns {string} the name or the digest of the board that is played there */
export const boardIn = (room) => (room === MAIN_ROOM ? MAIN_BOARD : room);
