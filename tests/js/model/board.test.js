// Where a player may aim.

import assert from "node:assert/strict";
import { test } from "node:test";

import { allowedAim } from "../../../static/js/model/board.js";

test("an aim is moved to the nearest allowed one", () => {
  const drop = { x: 0, jitter: 0.30870588235294116, reach: 0.6, aim: 0.2 };
  for (const x of [-5, -0.2001, 0.2, 0.31, 5]) {
    assert.ok(Math.abs(allowedAim({ drop }, [], x)) <= drop.aim, `${x}`);
  }
  assert.equal(allowedAim({ drop }, [], 0.12345), 0.1234);
  assert.equal(allowedAim({ drop }, [], 5), 0.2);
  assert.equal(allowedAim({ drop }, [-1.5, 0.25, 1.5], 0.8), 0.25);
  assert.equal(allowedAim({ drop: { ...drop, reach: 0.4 } }, [], -5), -0.0912); // reach minus jitter
  assert.equal(Math.abs(allowedAim({ drop: { x: 0, jitter: 0.3 } }, [], 5)), 0);
});
