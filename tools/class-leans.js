// Measures the class's boards: how often a ball goes right at each lean, and whether that holds for other seeds.
//
//   node tools/class-leans.js      (four minutes; writes static/js/class/leans.json and tools/class-leans.json)
//
// The first seeds choose the leans. Later seeds judge them, at every number of rows and at probabilities between the
// measured ones.

import { readFileSync, writeFileSync } from "node:fs";

import { leaning, leanOf, P, RESTITUTION, ROWS } from "../static/js/class/board.js";
import { openSolver } from "../static/js/solver/solver.js";

const ROOT = new URL("..", import.meta.url);
const LEANS = new URL("static/js/class/leans.json", ROOT);
const JUDGED = new URL("tools/class-leans.json", ROOT);
const GRAVITY = 9.81;
const STEP = 0.005; // between two leans, in spacings per row
const STEPS = 14;
const SAMPLE = [5, 8, 12, 18, 24, 30]; // rows
const CHOOSING = 20_000; // drops for each of them
const JUDGING = 200_000; // rows that balls pass: the standard error of a probability is 0.001
const FIRST = 1_000_000; // the first seed that judges

const solver = await openSolver(readFileSync(new URL("static/js/solver/kernels.wasm", ROOT)));

/**
 * @param {import("../static/js/model/board.js").Board} board @param {number} first seed @param {number} drops
 * @returns {{rights: number, spread: number}} how often balls went right in all, and the variance of their bins
 */
function count(board, first, drops) {
  const { bins } = solver.dropMany(board, Array.from({ length: drops }, (_, i) => first + i));
  if (bins.includes(-1)) throw new Error("a ball came to rest");
  const rights = bins.reduce((sum, bin) => sum + bin, 0);
  return { rights, spread: bins.reduce((sum, bin) => sum + (bin - rights / drops) ** 2, 0) / (drops - 1) };
}

const leans = Array.from({ length: STEPS + 1 }, (_, i) => {
  const lean = Number((i * STEP).toFixed(3));
  if (i === 0) return [0, 0.5]; // by symmetry
  const each = SAMPLE.map((rows) =>
    count(leaning(rows, lean, RESTITUTION, GRAVITY), 0, CHOOSING).rights / (rows * CHOOSING));
  return [lean, Number((each.reduce((sum, p) => sum + p, 0) / SAMPLE.length).toFixed(4))];
});
writeFileSync(LEANS, `{"leans": ${JSON.stringify(leans)}}\n`);

const judged = [];
for (let rows = ROWS.least; rows <= ROWS.most; rows += 1) {
  for (let p = 100 * P.least; p <= 100 * P.most; p += 5) {
    const drops = Math.round(JUDGING / rows);
    const board = leaning(rows, leanOf(p / 100, leans), RESTITUTION, GRAVITY);
    const { rights, spread } = count(board, FIRST, drops);
    const q = rights / (rows * drops);
    judged.push({
      rows, p: p / 100, drops, measured: Number(q.toFixed(4)), variance: Number((spread / (rows * q * (1 - q))).toFixed(3)),
    });
  }
}
const lines = judged.map((each) => JSON.stringify(each)).join(",\n ");
writeFileSync(JUDGED, `{"first_seed": ${FIRST}, "judged": [\n ${lines}\n]}\n`);
