// Paths that the page computed: at any time the drawn ball is where the solver says.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { Path } from "../../../../static/js/model/motion/path.js";
import { PathFeed } from "../../../../static/js/model/table/path-feed.js";
import { Table } from "../../../../static/js/model/table/table.js";
import { openSolver } from "../../../../static/js/solver/solver.js";
import { near, triangle } from "../../support.js";

const RATE = 60;
const KERNELS = new URL("../../../../static/js/solver/kernels.wasm", import.meta.url);
const solver = await openSolver(readFileSync(KERNELS));
const board = solver.read(triangle());
const START = 7.25; // table time, s

function feedOf(seed, from = START) {
  const solved = solver.drop(board, { seed });
  const path = new Path({ gravity: board.gravity, drag: board.drag });
  return { solved, path, feed: new PathFeed(path, solved, board, { start: START, from, rate: RATE }) };
}

test("a ball is drawn where the solver says, also at impacts", () => {
  for (const seed of ["1", "2", "3"]) {
    const { solved, path, feed } = feedOf(seed);
    for (let t = 0; t < solved.duration + 0.1; t += 1 / RATE) feed.until(START + t);
    const times = Array.from({ length: 2000 }, (_, i) => (i / 2000) * solved.duration);
    for (const { t, x, y } of solved.states(times)) {
      const pose = path.poseAt(START + t);
      near(pose.x, x, 1e-6, `seed ${seed} at ${t}`);
      near(pose.y, y, 1e-6, `seed ${seed} at ${t}`);
    }
    near(path.end, START + solved.duration, 0);
  }
});

test("each impact is reported once, in order, with its speed", () => {
  const { solved, feed } = feedOf("5");
  const heard = [];
  for (let t = 0; t < solved.duration + 1; t += 0.05) {
    feed.until(START + t, (at, impact) => heard.push({ at, ...impact }));
  }
  const hits = solved.impacts.filter(([, , , , , , kind]) => kind <= 1);
  assert.deepEqual(heard.map(({ at, x, y }) => [at, x, y]), hits.map(([t, x, y]) => [START + t, x, y]));
  assert.ok(heard.every(({ speed }) => speed >= 0) && heard.some(({ speed }) => speed > 1));
});

test("a late client sees a ball in flight, without old impacts", () => {
  const early = feedOf("5");
  const late = feedOf("5", START + 1.234);
  const heard = [];
  late.feed.until(START + 2, (at) => heard.push(at));
  early.feed.until(START + 2);
  near(late.path.start, START + 1.234, 0);
  assert.ok(heard.every((at) => at > START + 1.234));
  for (const t of [1.234, 1.3, 1.77, 2]) {
    near(late.path.poseAt(START + t).y, early.path.poseAt(START + t).y, 1e-6);
  }
});

test("a brief landing is completed only if digests agree", () => {
  const hello = { board, tick_rate: RATE, tick: 0, stream: "seeds", balls: [] };
  const table = new Table(hello, (start) => solver.drop(board, start));
  const solved = solver.drop(board, { seed: "11" });
  for (const ball of [0, 1]) table.accept({ ball, seed: "11", tick: 0 }, false);
  assert.equal(table.applyLanded({ ball: 0, digest: solved.digest.slice(0, 12) }), true);
  const { landed, end } = table.balls.get(0);
  assert.deepEqual([landed.bin, landed.score, landed.t], [solved.bin, solved.score, solved.duration]);
  assert.ok(solved.digest.startsWith(landed.digest));
  assert.equal(end, solved.duration);
  assert.equal(table.applyLanded({ ball: 1, digest: "000000000000" }), false);
  assert.equal(table.balls.get(1).landed, null);
});

test("a ball whose landing is late sinks into its bin", () => {
  const hello = { board, tick_rate: RATE, tick: 0, stream: "seeds", balls: [] };
  const table = new Table(hello, (start) => solver.drop(board, start));
  table.accept({ ball: 0, seed: "2", tick: 0 }, false);
  const { duration } = solver.drop(board, { seed: "2" });
  let lowest = 0;
  for (let t = 0; t < duration + 0.5; t += 1 / RATE) {
    for (const { y } of table.sceneAt(t, t).balls) lowest = Math.max(lowest, y);
  }
  assert.ok(lowest > board.bins.y + board.ball.radius);
});

test("a traced path has its start, every corner and its end", () => {
  const hello = { board, tick_rate: RATE, tick: 0, stream: "seeds", balls: [] };
  const table = new Table(hello, (start) => solver.drop(board, start));
  table.tracing = true;
  const solved = solver.drop(board, { seed: "3" });
  table.accept({ ball: 0, seed: "3", tick: 0 }, true);
  table.applyLanded({ ball: 0, digest: solved.digest });
  for (let t = 0; t < solved.duration + 0.1; t += 1 / RATE) {
    table.settle(t, t);
    table.sceneAt(t, t);
  }
  const corners = [[solved.xStart, board.drop.y], ...solved.impacts.map(([, x, y]) => [x, y])];
  for (const [x, y] of corners) assert.ok(table.lastTrace.some((point) => point.x === x && point.y === y));
  assert.ok(table.lastTrace.length > 60 * solved.duration);
});
