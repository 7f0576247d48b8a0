// Tabs that share one account: none loses what another has counted, however late each sees the other's writes.

import assert from "node:assert/strict";
import { test } from "node:test";

import { balanceOf, GRANT, viewOf } from "../../../static/js/model/player/account.js";
import { Wallet } from "../../../static/js/play/account/wallet.js";
import { chance, storage } from "../support.js";

/**
 * A browser's storage as tabs in several processes see it: each has a copy, and writes reach the browser, and from
 * there the other copies, some time later. A copy keeps its own value while a write of it is on its way.
 */
class Browser {
  /** @type {Map<string, string>} */
  values = new Map();
  /** @type {{copy: Copy, key: string, value: string}[]} */
  writes = [];
  /** @type {Copy[]} */
  copies = [];

  open() {
    this.copies.push(new Copy(this));
    return this.copies.at(-1);
  }

  /** The write that has waited longest reaches the browser, which informs all tabs. */
  arrive() {
    const write = this.writes.shift();
    if (!write) return;
    this.values.set(write.key, write.value);
    for (const copy of this.copies) copy.news.push(write);
  }
}

/** One tab's view. */
class Copy {
  news = [];
  #own = new Map(); // writes on their way, by key

  constructor(browser) {
    this.browser = browser;
    this.values = new Map(browser.values);
  }

  getItem(key) {
    return this.values.get(key) ?? null;
  }

  setItem(key, value) {
    this.values.set(key, value);
    this.#own.set(key, (this.#own.get(key) ?? 0) + 1);
    this.browser.writes.push({ copy: this, key, value });
  }

  /** @returns {boolean} whether another tab's write has arrived: an event `storage` */
  hear() {
    const { copy, key, value } = this.news.shift() ?? {};
    if (!copy) return false;
    if (copy === this) this.#own.set(key, this.#own.get(key) - 1);
    else if (!this.#own.get(key)) this.values.set(key, value);
    return copy !== this;
  }
}

const staked = (session, drop) => ({ type: "staked", session, drop, stake: 250, room: "main", ball: drop, seed: "7" });
const settled = (session, drop, payout) => ({ type: "settled", session, drop, payout });

for (let seed = 0; seed < 40; seed += 1) {
  test(`two tabs that both drop 20 balls end with 40 (${seed})`, () => {
    const random = chance(seed);
    const browser = new Browser();
    const tabs = ["a", "b"].map((session) => {
      const copy = browser.open();
      const events = Array.from({ length: 20 }, (_, drop) => [staked(session, drop), settled(session, drop, 10 * drop)]);
      return { copy, wallet: new Wallet(copy), events: events.flat() };
    });
    const step = (tab) => {
      const what = Math.floor(3 * random());
      if (what === 0 && tab.events.length) tab.wallet.apply(tab.events.shift());
      else if (what === 1) browser.arrive();
      else if (tab.copy.hear()) void tab.wallet.account; // what the page does at each event `storage`
    };
    const busy = () => browser.writes.length > 0 || tabs.some(({ copy, events }) => copy.news.length || events.length);
    for (let steps = 0; busy(); steps += 1) {
      assert.ok(steps < 50_000, "the tabs come to rest");
      step(tabs[Math.floor(2 * random())]);
    }
    const due = GRANT - 40 * 250 + 2 * 10 * 190;
    const kept = new Wallet(browser.open());
    for (const { account } of [kept, ...tabs.map(({ wallet }) => wallet)]) {
      assert.equal(balanceOf(account), due);
      const { balls, staked: all, returned, profit } = viewOf(account, 0);
      assert.deepEqual([balls, all, returned, profit], [40, 100, 38, -62]);
    }
  });
}

test("a damaged account counts as absent, and is known as damaged once", () => {
  const kept = storage();
  kept.setItem("plinko.account.1", '{"grants": 1, "sess');
  const wallet = new Wallet(kept);
  assert.deepEqual([wallet.damaged, balanceOf(wallet.account)], [true, GRANT]);
  assert.equal(new Wallet(kept).damaged, false);
  assert.equal(new Wallet(storage()).damaged, false);
});

test("an account damaged meanwhile is written again as this tab knows it", () => {
  const kept = storage();
  const wallet = new Wallet(kept);
  wallet.apply(staked("s", 0));
  kept.setItem("plinko.account.1", "null");
  assert.equal(balanceOf(wallet.account), GRANT - 250);
  wallet.apply(settled("s", 0, 100));
  assert.equal(balanceOf(new Wallet(kept).account), GRANT - 150);
});
