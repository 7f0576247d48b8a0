// Chooses the two drops to compare: the pair that the page opens with, and a second drop that differs from the first
// by its seed or by a small shift of its start. Pure.

import { startSpan } from "../model/board.js";
import { HOUSE, readBoardName } from "../model/presets.js";
import { nextDown, nextUp } from "../util/doubles.js";

/** @import { Board } from "../model/board.js" */
/** @import { DropAddress } from "../net/drop-address.js" */

const LAST_BIT = "bit";

/** Allowed shifts of the second start, m, as links name them; "bit" is the next double. */
const SHIFTS = [LAST_BIT, "1e-12", "1e-9", "1e-6", "1e-3"];

/**
 * @param {Board} board
 * @param {number} x the first ball's start, m
 * @param {string} shift one of SHIFTS
 * @returns {number} m; shifted to the left where the right is outside the drop zone
 */
function secondStart({ drop }, x, shift) {
  const most = Math.max(drop.x + startSpan(drop), ...(drop.slots ?? []));
  if (shift === LAST_BIT) return nextUp(x) <= most ? nextUp(x) : nextDown(x);
  const by = Number(shift);
  return x + by <= most ? x + by : x - by;
}

/**
 * The second drop. A shifted start is explicit, so the drop has no aim (the middle of the starts that a seed draws).
 * @param {Board} board
 * @param {DropAddress} first
 * @param {number} x where the first starts, m
 * @param {string} shift one of SHIFTS
 * @param {string | null} seed the second drop's seed, instead of a shift
 * @returns {DropAddress}
 */
export function secondDrop(board, first, x, shift, seed) {
  if (seed) return { ...first, seed, x: null };
  return { ...first, x: secondStart(board, x, shift), aim: null };
}

/** @param {string | null} text from a link @returns {string} one of SHIFTS */
export function readShift(text) {
  return SHIFTS.find((shift) => shift === text) ?? LAST_BIT;
}

/**
 * @typedef {object} OpeningPair
 * @property {string} seed of the first ball
 * @property {string} shift of the second ball's start
 */

// By the rows of the house table's triangle (its pegs are the same at every risk) or the board's name. Each pair has
// the smallest shift that leads to different bins within a thousand seeds, and few impacts.
/** @type {Record<string, OpeningPair>} */
const PAIRS = {
  8: { seed: "719", shift: "1e-12" },
  9: { seed: "15", shift: "1e-9" },
  10: { seed: "565", shift: "1e-12" },
  11: { seed: "12", shift: "1e-12" },
  12: { seed: "6", shift: "1e-12" },
  13: { seed: "7", shift: "1e-12" },
  14: { seed: "956", shift: "bit" },
  15: { seed: "165", shift: "bit" },
  16: { seed: "322243", shift: "1e-9" }, // the one of 400,000 seeds whose balls get 110x and 0.5x
  classic: { seed: "38", shift: "1e-12" },
  galton: { seed: "0", shift: "bit" },
};

/** @param {string} board a preset's name or a digest @returns {OpeningPair | null} null unless of the house table */
export function openingPair(board) {
  const known = readBoardName(board);
  if (!known || known.world !== HOUSE) return null;
  return PAIRS[known.kind === "triangle" ? known.rows : known.kind] ?? null;
}
