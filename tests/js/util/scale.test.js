// Axes have round ticks, and figures few digits.

import assert from "node:assert/strict";
import { test } from "node:test";

import { figure, powerText, powerTicks, prefixed, ticks } from "../../../static/js/util/scale.js";
import { nearly } from "../support.js";

test("axes have round ticks", () => {
  assert.deepEqual(ticks(0, 5.64, 6), [0, 1, 2, 3, 4, 5]);
  assert.deepEqual(ticks(0, 0.004, 3), [0, 0.002, 0.004]);
  assert.deepEqual(powerTicks(1e-18, 5, 8).map(powerText),
    ["10⁻¹⁸", "10⁻¹⁵", "10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "1"]);
});

test("steps go from one to two, to five, to ten", () => {
  assert.deepEqual(ticks(0, 8, 4), [0, 2, 4, 6, 8]);
  assert.deepEqual(ticks(0, 20, 5), [0, 5, 10, 15, 20]);
  assert.deepEqual(ticks(0, 30, 4), [0, 10, 20, 30]);
});

test("figures are short, with a real minus sign", () => {
  assert.deepEqual([0, 1.23456, -0.0000123, 123456, -42].map(figure),
    ["0", "1.235", "−1.23·10⁻⁵", "1.23·10⁵", "−42"]);
  const { unit, per } = prefixed(0.0032, "J");
  assert.equal(unit, "mJ");
  nearly(per, 1000, 1e-9);
});
