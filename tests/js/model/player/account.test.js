// Demo credits are a function of which events are known: no order, no repetition changes them.

import assert from "node:assert/strict";
import { test } from "node:test";

import {
  applied, balanceOf, GRANT, knownDrops, newAccount, openDrops, refillOf,
} from "../../../../static/js/model/player/account.js";

const after = (events, account = newAccount()) => events.reduce(applied, account);
const staked = (drop, stake, session = "s1") => (
  { type: "staked", session, drop, stake, room: "main", ball: 10 + drop, seed: "7" }
);
const settled = (drop, payout, session = "s1") => ({ type: "settled", session, drop, payout });

test("a stake is gone when the server has taken it, and what it won is there when it has landed", () => {
  assert.equal(balanceOf(newAccount()), GRANT);
  const taken = after([staked(0, 100)]);
  assert.equal(balanceOf(taken), GRANT - 100);
  assert.deepEqual(openDrops(taken), [
    { session: "s1", room: "main", drop: 0, stake: 100, ball: 10, seed: "7" },
  ]);
  const landed = applied(taken, settled(0, 250));
  assert.equal(balanceOf(landed), GRANT + 150);
  assert.deepEqual(openDrops(landed), []);
});

test("a void drop gives its stake back", () => {
  assert.equal(balanceOf(after([staked(0, 100), settled(0, 100)])), GRANT);
});

test("a landing heard twice, by a second tab or after a reload, counts once", () => {
  const once = after([staked(0, 100), settled(0, 250)]);
  for (const again of [settled(0, 250), settled(0, 999), staked(0, 100), staked(0, 500)]) {
    assert.equal(applied(once, again), once);
  }
});

test("a landing of a drop that nobody knows was staked pays nothing", () => {
  assert.equal(balanceOf(after([settled(0, 250)])), GRANT);
});

test("drops of several sessions are told apart, and each order of what two tabs hear ends alike", () => {
  const events = [
    staked(0, 100), settled(0, 20), staked(1, 300), staked(0, 50, "s2"), settled(0, 500, "s2"),
    settled(1, 0), staked(2, 70),
  ];
  const want = GRANT - 100 + 20 - 300 - 50 + 500 - 70;
  assert.equal(balanceOf(after(events)), want);
  for (let shift = 1; shift < events.length; shift += 1) {
    const other = [...events.slice(shift), ...events.slice(0, shift)];
    assert.equal(balanceOf(after([...other, ...events])), want);
  }
});

test("credits are refilled when they run out, once for two tabs that ask at a time", () => {
  assert.equal(refillOf(newAccount()), null);
  const poor = after([staked(0, GRANT - 100)]);
  const refill = refillOf(poor);
  assert.deepEqual(refill, { type: "granted", number: 2 });
  assert.equal(balanceOf(after([refill, refill], poor)), GRANT + 100);
});

test("sessions that are over become a sum, of which no event counts again; others stay", () => {
  let account = after([staked(0, 100, "going on")]);
  for (let k = 0; k < 50; k += 1) {
    const id = `s${k}`;
    account = after([
      staked(0, 100, id), { type: "over", session: id, total: 1 }, settled(0, 90, id),
    ], account);
  }
  assert.equal(balanceOf(account), GRANT - 100 - 50 * 10);
  assert.equal(Object.keys(account.sessions).length, 21);
  for (const again of [staked(0, 100, "s0"), settled(0, 90, "s0"), staked(1, 5, "s0")]) {
    assert.equal(applied(account, again), account);
  }
  assert.equal(knownDrops(account, "going on"), 1);
});

test("a session that is over stays until all its drops were heard of and have landed", () => {
  let account = after([staked(0, 100, "old"), { type: "over", session: "old", total: 2 }]);
  for (let k = 0; k < 30; k += 1) {
    const id = `s${k}`;
    account = after([staked(0, 1, id), settled(0, 1, id), { type: "over", session: id, total: 1 }], account);
  }
  account = after([staked(1, 100, "old"), settled(1, 300, "old"), settled(0, 0, "old")], account);
  assert.equal(balanceOf(account), GRANT + 100);
});

test("an account that was kept as JSON is the same", () => {
  const account = after([staked(0, 100), settled(0, 20), staked(1, 300)]);
  const kept = JSON.parse(JSON.stringify(account));
  assert.deepEqual(applied(kept, settled(1, 5)), applied(account, settled(1, 5)));
});
