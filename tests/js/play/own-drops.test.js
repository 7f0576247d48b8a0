// Each of the player's drops is reported once, whether or not it was shown before the table sent its landing.

import assert from "node:assert/strict";
import { test } from "node:test";

import { OwnDrops } from "../../../static/js/play/own-drops.js";

const BALL = { id: 4, seed: "7", x: 0.1, explicit: false };
const LANDED = { type: "landed", ball: 4, bin: 2, score: 3, t: 1, x_end: 0, digest: "00" };

/** One drop in flight, and the list of its reports from here on. */
function inFlight() {
  const told = [];
  const own = new OwnDrops({
    tell: (kind, value) => { if (kind !== "room") told.push([kind, value.score ?? value.payout, value.paid]); },
    say: (message) => told.push([message]),
  });
  own.add("d0", 2, false);
  own.accepted("d0", BALL, { session: "s", drop: 0 });
  return { own, told };
}

test("a ball that is shown early is reported once, immediately", () => {
  const { own, told } = inFlight();
  assert.deepEqual([own.unseen, own.count, own.held], [1, 1, 0]);
  own.seen(BALL, LANDED);
  own.seen(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 6]]);
  assert.deepEqual([own.unseen, own.count], [0, 1]);
  own.settled(BALL, LANDED);
  own.settled(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 6]]);
  assert.equal(own.count, 0);
});

test("a ball that is not shown early is reported at its landing", () => {
  const { own, told } = inFlight();
  own.settled(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 6]]);
});

test("if the table pays another sum, the account is corrected", () => {
  const { own, told } = inFlight();
  own.seen(BALL, LANDED);
  own.settled(BALL, { ...LANDED, score: 0.5 });
  assert.deepEqual(told, [["seen", 3, 6], ["corrected", 100, undefined]]);
});
