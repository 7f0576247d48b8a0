// Demo credits follow from the set of events: order and repetition do not change them.

import assert from "node:assert/strict";
import { test } from "node:test";

import {
  applied, balanceOf, GRANT, incompleteSessions, knownDrops, newAccount, openDrops, readAccount, refillOf, viewOf,
} from "../../../../static/js/model/player/account.js";

const after = (events, account = newAccount()) => events.reduce(applied, account);
const staked = (drop, stake, session = "s1") => (
  { type: "staked", session, drop, stake, room: "main", ball: 10 + drop, seed: "7" }
);
const settled = (drop, payout, session = "s1") => ({ type: "settled", session, drop, payout });

test("a stake is paid with the receipt, a win at the landing", () => {
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

test("the stake of a void drop is returned", () => {
  assert.equal(balanceOf(after([staked(0, 100), settled(0, 100)])), GRANT);
});

test("a landing that arrives twice counts once", () => {
  const once = after([staked(0, 100), settled(0, 250)]);
  for (const again of [settled(0, 250), settled(0, 999), staked(0, 100), staked(0, 500)]) {
    assert.equal(applied(once, again), once);
  }
});

test("a landing without a known stake pays nothing", () => {
  assert.equal(balanceOf(after([settled(0, 250)])), GRANT);
});

test("tabs agree in any order of events, by session", () => {
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

test("two tabs that top up at the same time do so once", () => {
  const poor = after([staked(0, GRANT - 100)]);
  const refill = refillOf(poor);
  assert.deepEqual(refill, { type: "granted", number: 2, amount: GRANT - 100 });
  assert.equal(balanceOf(after([refill, refill], poor)), GRANT);
  assert.deepEqual(refillOf(newAccount()), { type: "granted", number: 2, amount: GRANT });
  const old = { ...newAccount(), grants: 3 };
  assert.equal(balanceOf(old), 3 * GRANT, "an account from before sums existed");
  assert.equal(balanceOf(applied(old, { type: "granted", number: 4, amount: 500 })), 3 * GRANT + 500);
});

test("statistics and history follow from the account", () => {
  let account = after([staked(0, 100), staked(1, 200), staked(2, 100)]);
  let view = viewOf(account, 0.5);
  assert.deepEqual([view.staked, view.returned, view.profit, view.balance], [0, 0, 0, 995.5], "of landed balls only");
  const played = (seed) => ({ seed, bin: 1, score: 1 });
  account = after([
    { ...settled(0, 250), played: played("a") }, { ...settled(1, 100), played: played("b") }, settled(2, 100),
  ], account);
  view = viewOf(account, 0);
  assert.deepEqual([view.balls, view.wins, view.losses, view.best], [3, 1, 1, 2.5]);
  assert.deepEqual([view.staked, view.returned, view.profit, view.balance], [4, 4.5, 0.5, 1000.5]);
  assert.deepEqual(view.curve, [0, 1.5, 0.5, 0.5, 0.5]);
  assert.deepEqual(view.last.map(({ seed }) => seed), ["b", "a"]);
  account = applied(account, { type: "practised", played: played("c") });
  assert.deepEqual([viewOf(account, 0).balls, account.last[0].seed], [3, "c"]);
  account = applied(account, { type: "corrected", session: "s1", drop: 0, payout: 150 });
  assert.equal(viewOf(account, 0).profit, -0.5);
  assert.equal(applied(account, { type: "corrected", session: "s1", drop: 0, payout: 150 }), account);
  account = applied(account, { type: "reset" });
  view = viewOf(account, 0);
  assert.deepEqual([view.balls, view.profit, view.last.length, view.balance], [0, 0, 0, 999.5]);
});

test("the curve of very many drops is short and ends correctly", () => {
  let account = newAccount();
  for (let n = 0; n < 3000; n += 1) account = after([staked(n, 10), settled(n, n % 3 ? 0 : 40)], account);
  const { curve, profit, balls } = viewOf(account, 0);
  assert.equal(balls, 3000);
  assert.ok(curve.length <= 243);
  assert.equal(curve.at(-1), profit);
});

test("ended sessions become a sum, and late events are ignored", () => {
  let account = after([staked(0, 100, "going on")]);
  for (let k = 0; k < 50; k += 1) {
    const id = `s${k}`;
    account = after([
      staked(0, 100, id), { type: "over", session: id, total: 1 }, settled(0, 90, id),
    ], account);
  }
  assert.equal(balanceOf(account), GRANT - 100 - 50 * 10);
  assert.equal(Object.keys(account.sessions).length, 6);
  for (const again of [staked(0, 100, "s0"), settled(0, 90, "s0"), staked(1, 5, "s0")]) {
    assert.equal(applied(account, again), account);
  }
  assert.equal(knownDrops(account, "going on"), 1);
});

test("a long session takes little space, and its first drops count once", () => {
  let account = newAccount();
  for (let n = 0; n < 1000; n += 1) account = after([staked(n, 100), settled(n, n % 2 ? 0 : 150)], account);
  assert.equal(balanceOf(account), GRANT - 25_000);
  assert.ok(JSON.stringify(account.sessions).length < 3000);
  assert.equal(knownDrops(account, "s1"), 1000);
  for (const again of [staked(0, 100), settled(0, 150), staked(999, 100), settled(999, 150)]) {
    assert.equal(applied(account, again), account);
  }
  account = after([staked(1000, 100), staked(1001, 100), settled(1001, 100)], account);
  assert.deepEqual(openDrops(account).map(({ drop }) => drop), [1000], "a ball that falls is kept");
  account = after([settled(1000, 0), { type: "over", session: "s1", total: 1002 }], account);
  assert.equal(balanceOf(account), GRANT - 25_100);
  assert.deepEqual(incompleteSessions(account), []);
});

test("an ended session is kept until all its drops have landed", () => {
  let account = after([staked(0, 100, "old"), { type: "over", session: "old", total: 2 }]);
  for (let k = 0; k < 30; k += 1) {
    const id = `s${k}`;
    account = after([staked(0, 1, id), settled(0, 1, id), { type: "over", session: id, total: 1 }], account);
  }
  account = after([staked(1, 100, "old"), settled(1, 300, "old"), settled(0, 0, "old")], account);
  assert.equal(balanceOf(account), GRANT + 100);
});

test("sessions with unknown drops are known as such", () => {
  const ended = { type: "over", session: "s1", total: 2 };
  const account = after([staked(0, 100), settled(0, 0), ended]);
  assert.deepEqual(incompleteSessions(account), ["s1"]);
  assert.deepEqual(incompleteSessions(after([staked(1, 100)], account)), []);
  const unheard = { ...ended, room: "main" };
  assert.deepEqual(incompleteSessions(after([unheard])), ["s1"], "no receipt has arrived");
  assert.deepEqual(after([{ ...unheard, total: 0 }]).sessions, {}, "nothing was dropped");
});

test("a damaged account is not read, whatever is wrong with it", () => {
  const account = after([staked(0, 100), settled(0, 20), staked(1, 300)]);
  assert.deepEqual(readAccount(JSON.stringify(account)), account);
  assert.deepEqual(readAccount('{"grants": 3}'), { ...newAccount(), grants: 3 }, "an account of an older page");
  for (const damaged of [
    "", "{", "null", "5", "[]", '{"grants": -1}', '{"grants": "many"}', '{"sessions": []}', '{"sessions": {"s": {}}}',
    '{"sessions": {"s": {"room": "main", "drops": {"0": {"stake": 1.5, "payout": null}}}}}', '{"tally": {}}',
    '{"before": {"staked": 1}}', '{"last": [5]}', '{"last": [{}]}', '{"away": 5}',
  ]) assert.equal(readAccount(damaged), null, damaged);
});

test("an account survives storage as JSON", () => {
  const account = after([staked(0, 100), settled(0, 20), staked(1, 300)]);
  const kept = JSON.parse(JSON.stringify(account));
  assert.deepEqual(applied(kept, settled(1, 5)), applied(account, settled(1, 5)));
});
