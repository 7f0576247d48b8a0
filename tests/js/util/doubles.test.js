// The doubles next to a double, and its bits.

import assert from "node:assert/strict";
import { test } from "node:test";

import { bitsOf, nextDown, nextUp } from "../../../static/js/util/doubles.js";

test("no double lies between one and the next", () => {
  const values = [0.1, -0.1, 1, -1, 2 ** -1022, 1 - 2 ** -53, 123456.789, -(2 ** 40)];
  for (const x of values) {
    for (const [low, high] of [[x, nextUp(x)], [nextDown(x), x]]) {
      assert.ok(low < high, `${x}`);
      const middle = low / 2 + high / 2;
      assert.ok(middle === low || middle === high, `${x}`);
    }
  }
  assert.equal(nextUp(0), 5e-324);
  assert.equal(nextDown(0), -5e-324);
  assert.ok(Object.is(nextDown(5e-324), -0) || nextDown(5e-324) === 0);
});

test("a double is shown as sign, exponent and fraction", () => {
  assert.equal(bitsOf(-2), `1 10000000000 ${"0".repeat(52)}`);
  assert.equal(bitsOf(nextUp(1)), `0 01111111111 ${"0".repeat(51)}1`);
});
