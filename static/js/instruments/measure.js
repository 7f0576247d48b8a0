// Measures how often each bin is hit, in a sample of drops that the server computes.

import { postJson } from "../net/api.js";
import { t } from "../texts/text.js";

/** @import { Board } from "../model/board.js" */
/** @import { Simulation } from "../net/replies.js" */
/** @import { Expectation } from "./histogram.js" */

export const SAMPLE = 10_000; // drops

/** @param {Board} board @returns {Promise<Expectation & {counts: number[]}>} counts: of the sample */
export async function measure(board) {
  const { histogram } = /** @type {Simulation} */ (await postJson("simulate", { board, drops: SAMPLE }));
  const total = histogram.reduce((sum, count) => sum + count, 0);
  const label = t("lab.label-measured", { n: total });
  return { label, chances: histogram.map((count) => count / total), counts: histogram };
}
