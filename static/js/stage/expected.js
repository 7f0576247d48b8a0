// How often each bin of a room's board should be hit, and how that is known.

import { measure } from "../instruments/measure.js";
import { readBoardName } from "../model/presets.js";
import { getJson } from "../net/api.js";
import { t } from "../texts/text.js";

/** @import { Expectation } from "../instruments/histogram.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { OddsReply } from "../net/replies.js" */
/** @import { Theory } from "./wishes.js" */

/**
 * Of a draw its published odds. Of a preset as its landings were counted, of another board as drops hit it that the server computes
 * now; or of an ideal Galton board with as many bins. Throws where the server does not answer.
 * @param {Pick<Hello, "board" | "board_name" | "board_digest" | "draw">} hello @param {Theory} theory
 * @returns {Promise<Expectation>}
 */
export async function expectedOn({ board, board_name: name, board_digest: digest, draw }, theory) {
  if (draw) return published(draw.weights);
  if (theory === "binomial") return binomial(board.bins.multipliers.length);
  if (readBoardName(name)) {
    const { board_digest: counted, aims } = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
    if (counted === digest && aims.length) {
      return { label: t("lab.label-counted", { n: aims[0].drops }), chances: aims[0].chances };
    }
  }
  return measure(board);
}

/** @param {number[]} weights of the bins @returns {Expectation} exact: no path of a ball decides its bin there */
function published(weights) {
  const sum = weights.reduce((total, weight) => total + weight, 0);
  return { label: t("stage.published"), chances: weights.map((weight) => weight / sum) };
}

/** @param {number} bins @returns {Expectation} of a ball that goes left or right alike at each row */
export function binomial(bins) {
  const rows = bins - 1;
  const chances = [0.5 ** rows];
  for (let bin = 1; bin < bins; bin += 1) chances.push((chances[bin - 1] * (rows - bin + 1)) / bin);
  return { label: t("stage.binomial", { n: rows }), chances };
}
