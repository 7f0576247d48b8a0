// The expected probability of each bin of a room's board, and its source.

import { measure } from "../instruments/measure.js";
import { recorded } from "../model/odds.js";
import { readBoardName } from "../model/presets.js";
import { binomialChances } from "../model/statistics.js";
import { getJson } from "../net/api.js";
import { t } from "../texts/text.js";

/** @import { Expectation } from "../instruments/histogram.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { OddsReply } from "../net/replies.js" */
/** @import { Theory } from "./options.js" */

/**
 * In a draw, its published odds; for a preset, its recorded landings; for another board, a sample that the server
 * computes now. With the theory "binomial", an ideal Galton board with as many bins. Rejects if the server fails.
 * @param {Pick<Hello, "board" | "board_name" | "board_digest" | "draw">} hello @param {Theory} theory
 * @returns {Promise<Expectation>}
 */
export async function expectedOn({ board, board_name: name, board_digest: digest, draw }, theory) {
  if (draw) return published(draw.weights);
  if (theory === "binomial") return binomial(board.bins.multipliers.length);
  if (readBoardName(name)) {
    const { board_digest: counted, aims } = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
    if (counted === digest && aims.length) return recorded(aims[0]);
  }
  return measure(board);
}

/** @param {number[]} weights of the bins @returns {Expectation} exact, as the draw decides the bin, not the path */
function published(weights) {
  const sum = weights.reduce((total, weight) => total + weight, 0);
  return { label: t("stage.published"), chances: weights.map((weight) => weight / sum) };
}

/** @param {number} bins @returns {Expectation} of a ball that goes left or right with equal chances at each row */
export function binomial(bins) {
  return { label: t("stage.binomial", { n: bins - 1 }), chances: binomialChances(bins - 1, 0.5) };
}
