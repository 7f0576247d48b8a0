// The second ball of a comparison: another seed's, or the first's with its start moved a little. Pure.

import { startSpan } from "../model/board.js";
import { nextDown, nextUp } from "../util/doubles.js";

/** @import { Board } from "../model/board.js" */
/** @import { DropAddress } from "../net/drop-address.js" */

const LAST_BIT = "bit";

/** Metres by which the second start may differ, by the names in links. */
const SHIFTS = [LAST_BIT, "1e-12", "1e-9", "1e-6", "1e-3"];

/**
 * @param {Board} board
 * @param {number} x the first ball's start, m
 * @param {string} shift one of SHIFTS
 * @returns {number} m; to the left where the right is beyond the drop zone
 */
function secondStart({ drop }, x, shift) {
  const most = Math.max(drop.x + startSpan(drop), ...(drop.slots ?? []));
  if (shift === LAST_BIT) return nextUp(x) <= most ? nextUp(x) : nextDown(x);
  const by = Number(shift);
  return x + by <= most ? x + by : x - by;
}

/**
 * The second drop. An aim is the middle of what a seed draws: a start of one's own has none.
 * @param {Board} board
 * @param {DropAddress} first
 * @param {number} x where the first starts, m
 * @param {string} shift one of SHIFTS, by which the start is moved
 * @param {string | null} seed the second's own, in place of a shift
 * @returns {DropAddress}
 */
export function secondDrop(board, first, x, shift, seed) {
  if (seed) return { ...first, seed, x: null };
  return { ...first, x: secondStart(board, x, shift), aim: null };
}

/** @param {string | null} text of a link @returns {string} one of SHIFTS */
export function readShift(text) {
  return SHIFTS.find((shift) => shift === text) ?? LAST_BIT;
}
