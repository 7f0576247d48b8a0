// Stakes as players type them.

import assert from "node:assert/strict";
import { test } from "node:test";

import { allowedStake, mostCredits, readStake, typed } from "../../../static/js/play/desk/amounts.js";

test("a stake has a comma or a point, and at most two decimals", () => {
  for (const [text, stake] of [["1", 1], ["0.5", 0.5], ["0,5", 0.5], [".25", 0.25], ["2.", 2], [" 10.50 ", 10.5], ["1,000", 1000], ["12,345.6", 12345.6], ["1.239", 1.24]]) {
    assert.equal(readStake(text), stake, text);
  }
});

test("invalid stakes are refused", () => {
  for (const text of ["", " ", "0", "-1", "abc", "1e3", "1.2.3", "NaN", "1000001", "０.5"]) assert.equal(readStake(text), null, text);
});

test("half, double and all stay within the server's limits", () => {
  assert.deepEqual([0.01 / 2, 2 * 1e6, 999.999, 0.3].map((stake) => allowedStake(stake)), [0.01, 1e6, 999.99, 0.3]);
  assert.equal(typed(1234.5), "1234.5");
});

test("a stake is so low that its payout is exact", () => {
  assert.equal(mostCredits(null), 1e6);
  assert.equal(mostCredits([0.5, 110]), 1e6);
  assert.equal(mostCredits([1, 1e9]), 90071.99);
  assert.equal(readStake("90071.99", mostCredits([1e9])), 90071.99);
  assert.equal(readStake("90072", mostCredits([1e9])), null);
  assert.equal(allowedStake(100_000, mostCredits([1e9])), 90071.99);
});
