// Measures how often each bin is hit, in a sample of drops that a worker computes.

import { Batch } from "../solver/many/batch.js";
import { t } from "../texts/text.js";

/** @import { Board } from "../model/board.js" */
/** @import { Expectation } from "./histogram.js" */

export const SAMPLE = 10_000; // drops

/** @param {Board} board @returns {Promise<Expectation & {counts: number[]}>} counts: of the sample */
export async function measure(board) {
  const tally = await new Batch({ board, first: "0", drops: SAMPLE }, () => {}).done;
  const counts = tally?.histogram ?? [];
  const total = counts.reduce((sum, count) => sum + count, 0);
  return { label: t("lab.label-measured", { n: total }), chances: counts.map((count) => count / total), counts };
}
