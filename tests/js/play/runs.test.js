// Balls that are reported together: the sum counts each of them, and says why an auto-drop ended.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Run } from "../../../static/js/play/runs.js";
import { near } from "../support.js";

const NEVER = Number.POSITIVE_INFINITY;

/** A run whose table accepts every ball. @returns {{run: Run, land: (ref: string, paid: number) => void}} */
function running(limits = null) {
  const run = new Run(limits);
  let count = 0;
  const drop = () => `d${count++}`;
  const land = (ref, paid, more = {}) => run.land({ ref, stake: 1, paid, score: paid, bin: 1, ...more });
  return { run, drop, land };
}

test("a pause is not followed by a burst", () => {
  const { run, drop } = running();
  run.add(100, drop, 0, 10);
  const taken = (from, to) => {
    const before = run.falling;
    for (let now = from; now < to; now += 5) run.give(now, () => true);
    return run.falling - before;
  };
  const given = [taken(0, 1000), taken(60_000, 60_100), taken(60_100, 61_100)];
  assert.equal(given[0], 10);
  assert.ok(given[1] <= 2);
  near(given[2], 10, 1);
  assert.equal(run.left, 100 - given[0] - given[1] - given[2]);
});

test("an auto-drop stopped by its loss limit reports all balls", () => {
  const { run, drop, land } = running({ win: NEVER, loss: 1.5 });
  run.add(NEVER, drop, 0, 1000);
  for (let now = 0; now < 4; now += 1) run.give(now, () => true);
  assert.equal(run.falling, 4);
  land("d0", 0.5);
  land("d1", 0);
  assert.deepEqual([run.stopped, run.left, run.over], ["loss", 0, false]);
  land("d2", 0.5);
  assert.equal(run.over, false);
  land("d3", 0.2);
  assert.equal(run.over, true);
  assert.equal(run.words().text, "Stopped at your loss limit: 4 balls, −2.80");
});

test("profit or a count ends it; practice does not count", () => {
  const won = running({ win: 3, loss: NEVER });
  won.run.add(NEVER, won.drop, 0, 1000);
  for (let now = 0; now < 3; now += 1) won.run.give(now, () => true);
  won.land("d0", 5, { practice: true });
  assert.equal(won.run.stopped, null);
  won.land("d1", 4);
  won.land("d2", 0);
  assert.equal(won.run.words().text, "Stopped at your profit limit: 3 balls, +2.00");
  const counted = running({ win: NEVER, loss: NEVER });
  counted.run.add(1, counted.drop, 0);
  counted.run.give(0, () => true);
  counted.land("d0", 1);
  assert.equal(counted.run.words().text, "Auto finished: 1 ball, 0.00");
});

test("one ball is reported by its payout, several by their sums", () => {
  const one = running();
  one.run.add(1, one.drop, 0);
  one.run.give(0, () => true);
  one.land("d0", 1.4);
  assert.deepEqual(one.run.words(), { text: "1.4x  +0.40", score: 1.4 });
  const some = running();
  some.run.add(2, some.drop, 0);
  some.run.give(0, () => true);
  some.run.give(1000, () => true);
  some.land("d0", 0.5);
  some.land("d1", 2.7);
  assert.equal(some.run.words().text, "2 balls: staked 2, won 3.20 (+1.20)");
  const practice = running();
  practice.run.add(1, practice.drop, 0);
  practice.run.give(0, () => true);
  practice.land("d0", 9, { practice: true });
  assert.equal(practice.run.words().text, "9x (practice)");
});

test("a refused ball does not count, and a full table delays it", () => {
  const { run, drop } = running();
  run.add(1, drop, 0);
  assert.ok(run.give(0, () => false) > 0);
  assert.equal(run.left, 1);
  run.give(1000, () => true);
  assert.equal(run.refuse("d0"), true);
  assert.deepEqual([run.over, run.words()], [true, null]);
});
