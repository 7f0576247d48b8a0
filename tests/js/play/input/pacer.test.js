// Drops at a steady rate.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Pacer } from "../../../../static/js/play/input/pacer.js";
import { near } from "../../support.js";

test("a pause is not made up for by a burst", () => {
  const pacer = new Pacer(10, 100, 0);
  const taken = (from, to) => {
    let count = 0;
    for (let now = from; now < to; now += 5) if (pacer.take(now)) count += 1;
    return count;
  };
  const given = [taken(0, 1000), taken(60_000, 60_100), taken(60_100, 61_100)];
  assert.equal(given[0], 10);
  assert.ok(given[1] <= 2);
  near(given[2], 10, 1);
  assert.equal(pacer.left, 100 - given[0] - given[1] - given[2]);
});
