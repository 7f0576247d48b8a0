// What the rooms of this device share, where there is no server.

import { MAIN_BOARD, MAIN_ROOM } from "../model/presets.js";
import { openSolver } from "../solver/solver.js";

export const ON_DEVICE = "device-"; // begins the id of each session

/** @type {ReturnType<typeof openSolver> | null} */
let opening = null;

/** Computes the results; opened for the first one. */
export const openOnce = () => (opening ??= openSolver());

/** @param {string} room @returns {string} the name or the digest of the board that is played there */
export const boardIn = (room) => (room === MAIN_ROOM ? MAIN_BOARD : room);
