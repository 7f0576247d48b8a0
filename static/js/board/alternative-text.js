// The alternative text of a board's picture, for screen readers. Pure.

import { boardWords } from "../model/worlds.js";
import { t } from "../texts/text.js";
import { multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */

/** @param {Board} board @returns {string} */
export function describeBoard(board) {
  const { multipliers } = board.bins;
  const rows = new Set(board.pegs.map((peg) => peg.y.toFixed(6))).size;
  const middle = multipliers[Math.floor(multipliers.length / 2)];
  const [edge, inner] = [multipliers[0], middle].map(multiplier);
  return t("page.board-picture", { name: boardWords(board.name), rows, bins: multipliers.length, edge, middle: inner });
}
