// A lesson: its link, its balls, and the table for a spreadsheet.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { csvOf } from "../../../static/js/class/trial.js";
import { changed, readLesson, writeLesson } from "../../../static/js/class/lesson.js";
import { Trial } from "../../../static/js/class/trial.js";
import { openSolver } from "../../../static/js/solver/solver.js";

const solver = await openSolver(readFileSync(new URL("../../../static/js/solver/kernels.wasm", import.meta.url)));
const EIGHT = readLesson("#rows=8").setting;
const sum = (values) => values.reduce((total, value) => total + value, 0);

function restored(setting, runs) {
  const trial = new Trial(solver, setting);
  trial.restore(runs);
  return trial;
}

test("a link restores settings, view, guess and runs", () => {
  const lesson = {
    setting: { rows: 9, p: 0.35, restitution: 0.7, gravity: 1.62 }, change: "p:0.6", view: "means", size: 25,
    guess: [0, 1, 2, 3, 4, 5, 6, 7, 8, 100], runs: [{ seed: 4_294_967_295, drops: 40 }, { seed: 7, drops: 3 }],
  };
  assert.deepEqual(readLesson(writeLesson(lesson)), lesson);
});

test("what a link has wrong is replaced by what is usual", () => {
  const { setting, view, guess, change, runs } = readLesson("#rows=99&p=x&gravity=-4&view=secret&guess=1,2&change=rows:5");
  assert.deepEqual(setting, { rows: 30, p: 0.5, restitution: 0.8, gravity: 1 });
  assert.deepEqual([view, guess, change, runs], ["bins", null, "", []]);
  assert.equal(sum(readLesson("#runs=1x9999_2x9999").runs.map(({ drops }) => drops)), 2000, "a page must open soon");
});

test("the second board differs in one thing", () => {
  assert.equal(changed(EIGHT, ""), null);
  assert.deepEqual(changed(EIGHT, "restitution:0.6"), { ...EIGHT, restitution: 0.6 });
});

test("the same runs give the same balls, and each ball's turns lead to its bin", () => {
  const runs = [{ seed: 5, drops: 150 }, { seed: 900, drops: 150 }];
  const [one, two] = [restored(EIGHT, runs), restored(EIGHT, runs)];
  const { bins, counts, rights } = one.over(true);
  assert.deepEqual(two.over(true).bins, bins);
  assert.equal(sum(counts), 300);
  assert.deepEqual(sum(one.over(false).counts), 150);
  // A ball that hops over a peg goes right twice in one row.
  assert.ok(Math.abs(sum(rights) - sum(bins)) <= 2, `${sum(rights)} turns to the right, ${sum(bins)} in the bins`);
});

test("a falling ball starts above the first row, follows its path and ends in its bin", () => {
  const trial = new Trial(solver, EIGHT, 3);
  trial.enter("3", null, false);
  const [{ fall }] = trial.balls;
  const drop = solver.drop(trial.board, { seed: "3" });
  for (const at of [0, 0.1, 0.5, 1, fall.end]) {
    const { x, y } = fall.placeAt(at);
    const [state] = drop.states([Math.min(at, fall.end - 1e-9)]);
    assert.ok(Math.hypot(x - state.x, y - state.y) < 1e-4, `at ${at} s`);
  }
});

test("a new run loses no ball of the last one", () => {
  const trial = new Trial(solver, EIGHT, 5);
  trial.enter("5", null, true);
  trial.drop(3);
  while (trial.balls.length < 4) trial.advance(0); // in parts, as in the frames of a page
  trial.begin(70);
  assert.deepEqual(trial.runs.map(({ bins }) => bins.length), [4, 0]);
  trial.clear();
  assert.deepEqual(trial.runs.map(({ bins }) => bins.length), [0]);
});

test("the average goes by the order of dropping, and waits for a ball that falls longer than later ones", () => {
  const trial = new Trial(solver, EIGHT, 5);
  trial.drop(50);
  while (trial.balls.length < 50) trial.advance(0);
  for (const ball of trial.balls) ball.since = 0; // however long the drops took to compute
  const [slow] = trial.balls.toSorted((one, two) => two.fall.end - one.fall.end);
  const sooner = trial.balls.filter(({ place }) => place < slow.place).map(({ fall }) => fall.bin);
  trial.advance(1000 * slow.fall.end - 1);
  assert.equal(trial.over(true).bins.length, 49);
  assert.deepEqual(trial.settled(true), sooner);
  trial.advance(Infinity);
  assert.equal(trial.settled(true).length, 50);
});

test("two balls a nanometre apart part, and are not counted", () => {
  const trial = new Trial(solver, { ...EIGHT, rows: 30 });
  trial.calm = true;
  trial.twins(1e-9);
  assert.ok(trial.parting !== null && trial.parting > 1);
  trial.advance(0);
  assert.equal(trial.over(true).bins.length, 0);
});

test("a spreadsheet gets a line for each ball, separated as its language expects", () => {
  const trial = restored(EIGHT, [{ seed: 5, drops: 2 }]);
  const [first, second] = trial.run.bins;
  assert.equal(csvOf([trial], "en"), `board,run,ball,seed,right,rows\r\n1,1,1,5,${first},8\r\n1,1,2,6,${second},8\r\n`);
  assert.equal(csvOf([trial], "de").split("\r\n")[1], `1;1;1;5;${first};8`);
});
