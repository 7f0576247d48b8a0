// The class's boards: a ball goes right with the chosen probability, and the bins follow the binomial law.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { boardOf, RESTITUTION } from "../../../static/js/class/board.js";
import { openSolver } from "../../../static/js/solver/solver.js";

const FIRST = 5_000_000; // neither the leans nor their record have seen these seeds
const CHANCES = process.env.LONG ? [0.2, 0.37, 0.5, 0.66, 0.8] : [0.2, 0.5, 0.8];
const solver = await openSolver(readFileSync(new URL("../../../static/js/solver/kernels.wasm", import.meta.url)));
const settingOf = (rows, p, gravity = 9.81) => ({ rows, p, restitution: RESTITUTION, gravity });

function dropped(board, drops, first = FIRST) {
  return [...solver.dropMany(board, Array.from({ length: drops }, (_, i) => first + i)).bins];
}

function momentsOf(bins) {
  const mean = bins.reduce((sum, bin) => sum + bin, 0) / bins.length;
  return { mean, variance: bins.reduce((sum, bin) => sum + (bin - mean) ** 2, 0) / bins.length };
}

for (const rows of [5, 17, 30]) {
  test(`on ${rows} rows balls go right as often as chosen, and each row forgets the one before`, () => {
    for (const p of CHANCES) {
      const bins = dropped(boardOf(settingOf(rows, p)), Math.round(60_000 / rows));
      assert.ok(!bins.includes(-1), "a ball came to rest");
      const { mean, variance } = momentsOf(bins);
      const measured = mean / rows;
      assert.ok(Math.abs(measured - p) <= 0.01, `p ${p}: ${measured}`);
      const ratio = variance / (rows * measured * (1 - measured));
      assert.ok(Math.abs(ratio - 1) < 0.12, `p ${p}: variance ${ratio} of the binomial one`);
    }
  });
}

test("the board for 1 - p is the mirror image of that for p", () => {
  const [left, right] = [boardOf(settingOf(8, 0.3)), boardOf(settingOf(8, 0.7))];
  const places = (pegs) => pegs.map(({ x, y }) => `${x.toFixed(9)} ${y}`.replace("-0.000000000", "0.000000000")).sort();
  assert.deepEqual(places(left.pegs.map(({ x, y }) => ({ x: -x, y }))), places(right.pegs));
  assert.equal(left.drop.x, -right.drop.x);
});

test("without air, gravity changes how fast a ball falls, not where", () => {
  const [earth, slow] = [boardOf(settingOf(10, 0.5)), boardOf(settingOf(10, 0.5, 9.81 / 4))];
  const [one, two] = [dropped(earth, 300), dropped(slow, 300)];
  // A factor of 4 rounds alike, but for contacts that end at the same small speed on both boards.
  assert.ok(one.filter((bin, i) => bin === two[i]).length > 285);
});

test("the record of later seeds is within 0.01 for every number of rows", () => {
  const { judged } = JSON.parse(readFileSync(new URL("../../../tools/class-leans.json", import.meta.url), "utf8"));
  assert.equal(judged.length, 26 * 13);
  for (const { rows, p, measured } of judged) assert.ok(Math.abs(measured - p) <= 0.01, `${rows} rows, p ${p}: ${measured}`);
});
