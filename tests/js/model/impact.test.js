// Names of impacts.

import assert from "node:assert/strict";
import { test } from "node:test";

import { describe } from "../../../static/js/model/motion/event-names.js";

test("events are named by what the ball touched", () => {
  const events = [[0, 12], [1, 3], [2, 4], [2, -1], [4, -3], [5, 6]];
  assert.deepEqual(events.map(([kind, index]) => describe(kind, index)), [
    "peg 12", "wall 3", "rides peg 4", "rides wall 0", "leaves wall 2", "lands in bin 6",
  ]);
});
