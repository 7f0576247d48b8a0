// How close a ball came to a better bin.

import assert from "node:assert/strict";
import { test } from "node:test";

import { nearMiss } from "../../../../static/js/play/show/show.js";

const board = { ball: { radius: 0.1 }, bins: { y: 8, edges: [-1, 0, 1], multipliers: [0.5, 20] } };

test("a near miss is shown only next to a bin that pays much more", () => {
  assert.equal(nearMiss(board, 0, -0.0123), "Just missed 20x");
  assert.equal(nearMiss(board, 0, -0.06), "", "more than half a radius away");
  assert.equal(nearMiss(board, 1, 0.001), "", "the missed bin pays less");
});
