// The worker of batch.js: computes many drops on one board and reports its progress.

import { openSolver } from "../solver.js";
import { hearOwner } from "./threads.js";

/** @import { Asked, Told } from "./batch.js" */

const AT_ONCE = 500; // drops between two reports: some hundredths of a second

/** @param {Asked} asked */
async function run({ board, first, drops }) {
  const solver = await openSolver();
  const whole = solver.read(board);
  const tally = { drops: 0, histogram: whole.bins.multipliers.map(() => 0), unsettled: 0, time: 0 };
  while (tally.drops < drops) {
    const many = Math.min(AT_ONCE, drops - tally.drops);
    const seeds = Array.from({ length: many }, (_, i) =>
      BigInt.asUintN(64, BigInt(first) + BigInt(tally.drops + i)));
    const { bins, durations } = solver.dropMany(whole, seeds);
    for (const bin of bins) {
      if (bin < 0) tally.unsettled += 1;
      else tally.histogram[bin] += 1;
    }
    for (const duration of durations) tally.time += duration;
    tally.drops += many;
    tell({ tally });
  }
}

/** @type {(told: Told) => void} */
const tell = hearOwner((asked) => {
  run(/** @type {Asked} */ (asked)).catch((error) => tell({ error: error.message }));
});
