// The alternative text of a board, for those who do not see the picture. Pure.

import { multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */

/** @param {Board} board @returns {string} */
export function describeBoard(board) {
  const { multipliers } = board.bins;
  const rows = new Set(board.pegs.map((peg) => peg.y.toFixed(6))).size;
  const middle = multipliers[Math.floor(multipliers.length / 2)];
  return (
    `Plinko board ${board.name}: ${rows} rows of pegs over ${multipliers.length} bins that pay ` +
    `from ${multiplier(multipliers[0])} at the left edge to ${multiplier(middle)} in the middle.`
  );
}
