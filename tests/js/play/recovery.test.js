// Landings that a page missed are recovered from the export, and count once.

import assert from "node:assert/strict";
import { test } from "node:test";

import { balanceOf, GRANT, viewOf } from "../../../static/js/model/player/account.js";
import { ApiError } from "../../../static/js/net/api.js";
import { keepToken } from "../../../static/js/net/session-token.js";
import { Recovery } from "../../../static/js/play/account/recovery.js";
import { Wallet } from "../../../static/js/play/account/wallet.js";
import { storage as browser } from "../support.js";

const landed = (payout, bin = 3) => ({ bin, score: payout / 100, digest: "d1", payout });
const receipt = (drop) => ({ session: "s1", drop, stake: 100, room: "old", ball: drop, seed: "7",
  board_digest: "b1", aim: null });

/** A session's export, given the result of each drop, null for one in flight. */
function exported(results, end = null) {
  return {
    session: { statement: { session: "s1" } }, board: { name: "triangle-8" }, end,
    drops: results.map((result, drop) => ({ receipt: receipt(drop), result })),
  };
}

/** A tab whose requests get these replies, in order. */
function tab(storage, replies, token = "t1") {
  if (token) keepToken(storage, "s1", token);
  const wallet = new Wallet(storage);
  const told = { paths: [], shown: [], gone: [], found: [] };
  const quiet = {};
  quiet.promise = new Promise((resolve) => { quiet.resolve = resolve; });
  const recovery = new Recovery(wallet, {
    onFound: (played) => told.found.push(played.map(({ name, paid }) => [name, paid])),
    onChange: () => { if (wallet.open.length === 0) quiet.resolve(); },
    onGone: (drops) => told.gone.push(drops),
  }, async (path, options) => {
    told.paths.push(path);
    told.shown.push(options?.headers?.authorization);
    const reply = replies.shift();
    if (reply instanceof Error) throw reply;
    return reply;
  });
  return { wallet, recovery, told, done: quiet.promise };
}

const stakedOne = (wallet, drop = 0) => (
  wallet.apply({ type: "staked", session: "s1", drop, stake: 100, room: "old", ball: drop, seed: "7" })
);

test("after a reload, landings are requested and paid", async () => {
  const storage = browser();
  stakedOne(new Wallet(storage)); // the page before the reload
  const { wallet, recovery, told, done } = tab(storage, [exported([landed(250)])]);
  assert.equal(balanceOf(wallet.account), GRANT - 100);
  recovery.seekAllBut("new");
  await done;
  assert.deepEqual(told.paths, ["sessions/s1/export"]);
  assert.equal(balanceOf(wallet.account), GRANT + 150);
  assert.equal(viewOf(wallet.account, 0).profit, 1.5);
  assert.deepEqual(viewOf(wallet.account, 0).last[0].fair, { session: "s1", drop: 0 });
  await new Promise(setImmediate);
  assert.deepEqual(told.found, [[["triangle-8", 2.5]]], "the landing is reported with its board's name");
});

test("a session is requested with this browser's token", async () => {
  const storage = browser();
  keepToken(storage, "other", "t0");
  keepToken(storage, "s1", "t1");
  stakedOne(new Wallet(storage));
  const { recovery, told, done } = tab(storage, [exported([landed(250)])]);
  recovery.seekAllBut("new");
  await done;
  assert.deepEqual(told.shown, ["Bearer t1"]);
});

test("the stake in a session whose token is lost is returned", async () => {
  const storage = browser();
  stakedOne(new Wallet(storage));
  const { wallet, recovery, told, done } = tab(storage, [], null);
  recovery.seekAllBut("new");
  await done;
  assert.deepEqual(told.paths, [], "a request that would be refused is not sent");
  assert.equal(balanceOf(wallet.account), GRANT);
  assert.equal(told.gone.length, 1);
});

test("drops of the current room are not requested", () => {
  const storage = browser();
  stakedOne(new Wallet(storage));
  const { recovery, told } = tab(storage, []);
  recovery.seekAllBut("old");
  assert.deepEqual(told.paths, []);
});

test("a drop accepted during a crash is found with its stake", async () => {
  const storage = browser();
  const { wallet, recovery, done } = tab(storage, [exported([landed(0, 4), landed(300)])]);
  recovery.seek(["s1"]);
  await done;
  assert.equal(balanceOf(wallet.account), GRANT - 200 + 300);
});

test("the stake of a recovered void drop is returned", async () => {
  const storage = browser();
  const { wallet, recovery, done } = tab(storage, [exported([landed(100, null)])]);
  recovery.seek(["s1"]);
  await done;
  assert.equal(balanceOf(wallet.account), GRANT);
  assert.equal(viewOf(wallet.account, 0).last[0].bin, null);
});

test("a request is repeated while a ball falls or nothing answers", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const storage = browser();
  stakedOne(new Wallet(storage));
  const replies = [new ApiError("The server does not answer.", 0), exported([null]), exported([landed(20)])];
  const { wallet, recovery, told, done } = tab(storage, replies);
  recovery.seek(["s1"]);
  for (let looks = 1; looks < 3; looks += 1) {
    while (replies.length > 3 - looks) await Promise.resolve();
    await new Promise(setImmediate);
    t.mock.timers.tick(2 ** looks * 1000);
  }
  await done;
  assert.equal(told.paths.length, 3);
  assert.equal(balanceOf(wallet.account), GRANT - 80);
});

test("two tabs that find the same landing count it once", async () => {
  const storage = browser();
  stakedOne(new Wallet(storage));
  const one = tab(storage, [exported([landed(250)])]);
  const two = tab(storage, [exported([landed(250)])]);
  one.recovery.seek(["s1"]);
  two.recovery.seek(["s1"]);
  await one.done;
  await new Promise(setImmediate);
  for (const { wallet } of [one, two]) {
    assert.equal(balanceOf(wallet.account), GRANT + 150);
    const { staked, returned, last } = viewOf(wallet.account, 0);
    assert.deepEqual([staked, returned, last.length], [1, 2.5, 1]);
  }
});

test("the stakes of a session unknown to the ledger are returned", async () => {
  const storage = browser();
  stakedOne(new Wallet(storage));
  const { wallet, recovery, told, done } = tab(storage, [new ApiError("unknown", 404)]);
  recovery.seek(["s1"]);
  await done;
  assert.equal(balanceOf(wallet.account), GRANT);
  assert.deepEqual(told.gone, [1]);
});

test("a player's mark is the same in all tabs until renewed", () => {
  const shared = browser();
  const first = new Wallet(shared).mark;
  assert.match(first, /^[0-9a-f]{32}$/);
  assert.equal(new Wallet(shared).mark, first);
  const second = new Wallet(shared).renewMark();
  assert.notEqual(second, first);
  assert.equal(new Wallet(shared).mark, second);
  assert.equal(new Set(Array.from({ length: 100 }, () => new Wallet(browser()).mark)).size, 100);
});
