// The player's balls at a faster pace: their landings are seen early, and settle when the table sends them.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { PACES, shownEnd, timeInFall, timeSeen } from "../../../../static/js/model/table/pace.js";
import { Table } from "../../../../static/js/model/table/table.js";
import { openSolver } from "../../../../static/js/solver/solver.js";
import { near, triangle } from "../../support.js";

const RATE = 60;
const KERNELS = new URL("../../../../static/js/solver/kernels.wasm", import.meta.url);
const solver = await openSolver(readFileSync(KERNELS));
const board = solver.read(triangle());
const drop = solver.drop(board, { seed: "7" });

/** A table with one ball of that pace, dropped at tick 0. */
function falling(pace, mine = true) {
  const hello = { board, tick_rate: RATE, tick: 0, stream: "seeds", balls: [] };
  const table = new Table(hello, (start) => solver.drop(board, start));
  table.pace = pace;
  const ball = table.accept({ type: "accepted", ball: 0, seed: "7", tick: 0 }, mine);
  return { table, ball };
}

test("turbo shows the same path in a fifth of the time", () => {
  const { table, ball } = falling(PACES.turbo);
  const heard = [];
  let seen = null;
  for (let t = 0; t < drop.duration && seen === null; t += 1 / 240) {
    const [shown] = table.sceneAt(t, t).balls;
    const own = t * PACES.turbo;
    if (t > 0 && own < drop.duration) near(shown.y, drop.states([own])[0].y, 1e-6);
    heard.push(...table.heard.map((impact) => impact.t));
    if (table.settle(t, t).seen.length) seen = t;
  }
  near(seen, drop.duration / PACES.turbo, 1 / 240 + 1e-9);
  assert.deepEqual(ball.outcome && [ball.outcome.bin, ball.outcome.score], [drop.bin, drop.score]);
  const audible = drop.impacts.filter(([, , , , , , kind]) => kind <= 1).length;
  assert.ok(heard.length > audible / 2 && heard.length <= audible);
  assert.deepEqual(heard, [...heard].sort((one, two) => one - two));
});

test("an instant ball is forgotten when its landing arrives", () => {
  const { table, ball } = falling(PACES.instant);
  table.sceneAt(0, 0);
  assert.deepEqual(table.settle(0, 0), { seen: [ball], settled: [] });
  assert.deepEqual(table.settle(1, 1), { seen: [], settled: [] });
  assert.equal(table.sceneAt(1, 1).balls.length, 0, "its fall is not shown");
  assert.equal(table.awake, true, "but it still falls at the table");
  assert.equal(table.applyLanded({ type: "landed", ball: 0, digest: drop.digest.slice(0, 12) }), true);
  assert.deepEqual(table.settle(drop.duration, 2), { seen: [], settled: [ball] });
  table.sceneAt(drop.duration, 2);
  assert.equal(table.balls.size, 0);
});

test("a landing that differs from the shown one is reported", () => {
  const { table } = falling(PACES.instant);
  table.settle(0, 0);
  assert.equal(table.applyLanded({ type: "landed", ball: 0, digest: "000000000000" }), false);
});

test("others' balls are always shown at the table's pace", () => {
  for (const { table, ball } of [falling(PACES.instant, false), falling(PACES.real)]) {
    assert.deepEqual(table.settle(drop.duration + 1, 0), { seen: [], settled: [] });
    table.applyLanded({ type: "landed", ball: 0, digest: drop.digest.slice(0, 12) });
    assert.deepEqual(table.settle(drop.duration - 0.01, 0), { seen: [], settled: [] });
    assert.deepEqual(table.settle(drop.duration, 0), { seen: [ball], settled: [ball] });
  }
});

test("times convert between fall and table at every pace", () => {
  for (const pace of [PACES.real, PACES.turbo]) {
    const fall = { start: 3, end: 8, pace };
    for (const at of [3, 4.5, 8]) near(timeInFall(fall, timeSeen(fall, at)), at, 1e-12);
    near(timeInFall(fall, shownEnd(fall) + 0.1), 8.1, 1e-12);
  }
  assert.equal(timeInFall({ start: 3, end: 8, pace: PACES.instant }, 3.1), 8.1);
});
