// The guessing game, and the drop of the day.

import assert from "node:assert/strict";
import { test } from "node:test";

import { dropOfDay, guessWords } from "../../../static/js/replay/guess.js";

test("the drop of the day is the same everywhere, by UTC", () => {
  const drop = { board: "triangle-16", seed: "20270101" };
  assert.deepEqual(dropOfDay(new Date("2027-01-01T00:00:00Z")), drop);
  assert.deepEqual(dropOfDay(new Date("2027-01-02T01:59:59+02:00")), drop);
  assert.equal(dropOfDay(new Date("2027-01-02T00:00:00Z")).seed, "20270102");
});

test("a guess is right, or off by a number of bins", () => {
  assert.equal(guessWords(3, 3), " Your guess was right.");
  assert.equal(guessWords(4, 3), " Your guess was bin 4: 1 bin off.");
  assert.equal(guessWords(0, 3), " Your guess was bin 0: 3 bins off.");
});

test("without a guess or a bin nothing is said", () => {
  assert.equal(guessWords(null, 3), "");
  assert.equal(guessWords(3, null), "");
});
