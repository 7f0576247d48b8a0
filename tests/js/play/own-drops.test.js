// A drop of ours is told once, whether it was shown before the table told its landing or not, and counts once.

import assert from "node:assert/strict";
import { test } from "node:test";

import { OwnDrops } from "../../../static/js/play/own-drops.js";

const BALL = { id: 4, seed: "7", x: 0.1, explicit: false };
const LANDED = { type: "landed", ball: 4, bin: 2, score: 3, t: 1, x_end: 0, digest: "00" };

/** One drop in flight, and what is told of it from here on. */
function inFlight() {
  const told = [];
  const own = new OwnDrops({
    onSeen: ({ score }) => told.push(["seen", score, own.unseen]),
    onPlayed: ({ score }) => told.push(["played", score, own.count]),
    onError: (message) => told.push([message]),
  });
  own.add("d0", 2);
  own.accepted("d0", BALL, { session: "s", drop: 0 });
  return { own, told };
}

test("shown before it landed, it is told at once, counts later, and is told no second time", () => {
  const { own, told } = inFlight();
  own.seen(BALL, LANDED);
  own.seen(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 0]]);
  assert.equal(own.count, 1);
  own.settled(BALL, LANDED);
  own.settled(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 0], ["played", 3, 0]]);
});

test("heard of only when it had landed, it is told and counts at once", () => {
  const { own, told } = inFlight();
  own.settled(BALL, LANDED);
  assert.deepEqual(told, [["seen", 3, 0], ["played", 3, 0]]);
});
