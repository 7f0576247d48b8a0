// After a landing from 5x the hit pegs light up, and from 100x a close-up is shown before that.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { emptyScene } from "../../../../static/js/model/scene.js";
import { LandingZoom } from "../../../../static/js/play/show/landing-zoom.js";
import { openSolver } from "../../../../static/js/solver/solver.js";
import { triangle } from "../../support.js";

const bytes = readFileSync(new URL("../../../../static/js/solver/kernels.wasm", import.meta.url));
const solver = await openSolver(bytes);

/** What is shown at these times after a landing with this multiplier. */
function seen(pays, times, still = false) {
  const board = triangle();
  board.bins.multipliers = board.bins.multipliers.map(() => pays);
  board.drop = { ...board.drop, jitter: 0.25 };
  const whole = solver.read(board);
  const zoom = new LandingZoom();
  zoom.begin(solver.drop(whole, { seed: "42" }), board, (x) => solver.drop(whole, { x }), still);
  return times.map((wall) => {
    const scene = emptyScene();
    const goesOn = zoom.show(scene, wall, still, false);
    return { near: zoom.near !== null, looking: zoom.looking, lights: scene.flashes.length > 0, goesOn };
  });
}

test("a jackpot is shown close for two seconds, then its pegs", () => {
  const [first, last, after, end] = seen(100, [5, 7.3, 7.6, 10]);
  assert.deepEqual([first.near, first.looking, last.near, last.looking], [true, true, true, true]);
  assert.deepEqual(after, { near: false, looking: false, lights: true, goesOn: true });
  assert.deepEqual(end, { near: false, looking: false, lights: false, goesOn: false });
});

test("a win lights up; a smaller one or reduced motion does not", () => {
  assert.deepEqual(seen(5, [5, 5.3])[1], { near: false, looking: false, lights: true, goesOn: true });
  assert.deepEqual(seen(4, [5, 5.3])[1], { near: false, looking: false, lights: false, goesOn: false });
  assert.deepEqual(seen(100, [5, 5.3], true)[1], { near: false, looking: false, lights: false, goesOn: false });
});
