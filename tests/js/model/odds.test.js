// The odds of an aim.

import assert from "node:assert/strict";
import { test } from "node:test";

import { oddsAt, oddsWords } from "../../../static/js/model/odds.js";

const own = { aim: null, return: 0.98953, doubt: 0.00038, awards: [{ multiplier: 110, chance: 1 / 14205 }] };
const aside = { ...own, aim: 0.3, return: 0.98 };

test("the nearest counted aim stands for the chosen one", () => {
  const counted = /** @type {any[]} */ ([own, aside]);
  assert.equal(oddsAt(counted, null, 0), own);
  assert.equal(oddsAt(counted, 0.1, 0), own);
  assert.equal(oddsAt(counted, -0.2, 0), aside);
  assert.equal(oddsAt([], 0.1, 0), null);
});

test("a sentence says the return and the odds of the top award", () => {
  const said = oddsWords(/** @type {any} */ (own));
  assert.equal(said, "Average return 98.95 %. 110x about once in 14,205 balls.");
  const never = { ...own, awards: [{ multiplier: 9, chance: 0 }] };
  assert.match(oddsWords(/** @type {any} */ (never)), /9x has never come up in our tests/);
});
