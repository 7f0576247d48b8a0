// The second drop of a comparison: it differs from the first by its seed or by a small shift of its start. Pure.

import { startSpan } from "../model/board.js";
import { nextDown, nextUp } from "../util/doubles.js";

/** @import { Board } from "../model/board.js" */
/** @import { DropAddress } from "../net/drop-address.js" */

const LAST_BIT = "bit";

/** Allowed shifts of the second start, m, as links name them; "bit" is the next double. */
const SHIFTS = [LAST_BIT, "1e-12", "1e-9", "1e-6", "1e-3"];

/**
 * The second drop. A shifted start is explicit, so the drop has no aim (the middle of the starts that a seed draws).
 * @param {Board} board
 * @param {DropAddress} first
 * @param {number} x where the first starts, m
 * @param {string} shift one of SHIFTS; to the left where the right is outside the drop zone
 * @param {string | null} seed the second drop's seed, instead of a shift
 * @returns {DropAddress}
 */
export function secondDrop(board, first, x, shift, seed) {
  if (seed) return { ...first, seed, x: null };
  const { drop } = board;
  const most = Math.max(drop.x + startSpan(drop), ...(drop.slots ?? []));
  const [right, left] = shift === LAST_BIT ? [nextUp(x), nextDown(x)] : [x + Number(shift), x - Number(shift)];
  return { ...first, x: right <= most ? right : left, aim: null };
}

/** @param {string | null} text from a link @returns {string} one of SHIFTS */
export function readShift(text) {
  return SHIFTS.find((shift) => shift === text) ?? LAST_BIT;
}
