// Aims are stored by board.

import assert from "node:assert/strict";
import { test } from "node:test";

import { aims, keepAim, keptAim } from "../../../static/js/play/desk/aim.js";
import { storage } from "../support.js";

test("each board has its own aim, also in another tab", () => {
  const shared = storage();
  keepAim(shared, "classic", -0.25);
  keepAim(shared, "triangle-8", 0);
  assert.equal(keptAim(shared, "classic"), -0.25);
  assert.equal(keptAim(shared, "triangle-8"), 0);
  assert.equal(keptAim(shared, "triangle-9"), null);
});

test("an aim can be removed", () => {
  const kept = storage();
  keepAim(kept, "classic", -0.25);
  keepAim(kept, "classic", null);
  assert.equal(keptAim(kept, "classic"), null);
});

test("only the aims of the last boards are kept", () => {
  const kept = storage();
  for (let n = 0; n < 100; n += 1) keepAim(kept, `board ${n}`, n);
  assert.equal(keptAim(kept, "board 99"), 99);
  assert.equal(keptAim(kept, "board 0"), null);
});

test("aiming is offered only if it can move the ball by a radius", () => {
  const board = (aim, reach = 1) => ({ ball: { radius: 0.1 }, drop: { x: 0, jitter: 0.2, reach, aim } });
  assert.deepEqual([0.011, 0.1, 0.5].map((aim) => aims(board(aim), [])), [false, true, true]);
  assert.equal(aims(board(0.5, 0.25), []), false);
  assert.equal(aims(board(0), [0, 1]), true);
});
