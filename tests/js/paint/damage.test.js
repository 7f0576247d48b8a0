// Before the next frame, all that was painted is cleared, and little else.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Damage } from "../../../static/js/paint/damage.js";

/** @param {Damage} damage @returns {number[][]} the rectangles that it clears on 100 x 100 pixels */
function wiped(damage) {
  const boxes = [];
  damage.clear({ clearRect: (...box) => boxes.push(box) }, 100, 100);
  return boxes;
}

test("small marks are cleared one by one, once", () => {
  const damage = new Damage();
  damage.add(1, 2, 3, 4);
  damage.addPoints(Float64Array.of(50, 60, 55, 52), 2, 2);
  assert.deepEqual(wiped(damage), [[1, 2, 3, 4], [48, 50, 9, 12]]);
  assert.deepEqual(wiped(damage), []);
});

test("if much is painted, everything is cleared at once", () => {
  const damage = new Damage();
  damage.add(0, 0, 100, 61);
  assert.deepEqual(wiped(damage), [[0, 0, 100, 100]]);
  for (let i = 0; i < 5000; i += 1) damage.add(i % 100, 0, 0.01, 0.01);
  assert.deepEqual(wiped(damage), [[0, 0, 100, 100]]);
});
