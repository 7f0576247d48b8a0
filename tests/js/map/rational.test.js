// Starts on the map are exact at any zoom.

import assert from "node:assert/strict";
import test from "node:test";

import { pixelMiddle, rationalText, readRational } from "../../../static/js/map/rational.js";

test("a fraction is read, and written in lowest terms", () => {
  assert.equal(rationalText(readRational("6/8")), "3/4");
  assert.equal(rationalText(readRational("-10/5")), "-2");
  assert.equal(rationalText(readRational("0")), "0");
});

test("a pixel's middle is exact, far below a float64's rounding", () => {
  const width = readRational(`1/${10n ** 30n}`);
  const x = readRational("1/3");
  assert.equal(rationalText(pixelMiddle(readRational("0"), readRational("1"), 0, 2)), "-1/4");
  const middle = pixelMiddle(x, width, 159, 160);
  // 1/3 + 1e-30 * 159/320
  const expected = { top: 320n * 10n ** 30n + 3n * 159n, bottom: 960n * 10n ** 30n };
  assert.equal(rationalText(middle), rationalText(expected));
});
