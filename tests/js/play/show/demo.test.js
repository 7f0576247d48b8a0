// Demo balls fall like real ones, belong to no player, and end.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { DemoBalls } from "../../../../static/js/play/show/demo-balls.js";
import { openSolver } from "../../../../static/js/solver/solver.js";
import { near, triangle } from "../../support.js";

const KERNELS = new URL("../../../../static/js/solver/kernels.wasm", import.meta.url);
const solver = await openSolver(readFileSync(KERNELS));
const board = solver.read(triangle());
const solve = (start) => solver.drop(board, start);
const hello = { board, tick_rate: 60 };

test("the demo's balls fall as solved, win nothing, and it ends", () => {
  let seeds = 0;
  const demo = new DemoBalls(hello, solve, () => String((seeds += 1)));
  const began = 90_000;
  let most = 0;
  let now = began;
  for (; now < began + 120_000; now += 50) {
    const scene = demo.sceneAt(now);
    if (!scene) break;
    most = Math.max(most, scene.balls.length);
    assert.ok(scene.balls.every(({ mine }) => !mine));
    assert.ok(scene.hits.every(({ ticket }) => ticket === false));
    const first = scene.balls.find(({ id }) => id === 1);
    const fallen = (now - began) / 1000;
    const drop = solve({ seed: "1" });
    if (first && fallen < drop.duration) near(first.y, drop.states([fallen])[0].y, 1e-6);
  }
  assert.equal(seeds, 12);
  assert.ok(most >= 2 && most <= 4, "a quiet table stays calm");
  assert.ok(now < began + 40_000, "it ends by itself");
});
