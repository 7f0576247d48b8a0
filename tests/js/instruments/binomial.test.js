// What is expected of the bins.

import assert from "node:assert/strict";
import { test } from "node:test";

import { expectedOf } from "../../../static/js/instruments/binomial.js";
import { choose } from "../support.js";

test("the expected histogram of a triangle is the binomial", () => {
  for (const rows of [8, 16]) {
    const { chances, label } = expectedOf(`triangle-${rows}-high`, rows + 1);
    assert.deepEqual(chances, choose(rows).map((ways) => ways / 2 ** rows));
    assert.match(label, /binomial/);
  }
});

test("of other boards no law is claimed", () => {
  assert.equal(expectedOf("classic", 9), null);
});
