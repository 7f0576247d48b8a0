// The guessing game.

import assert from "node:assert/strict";
import { test } from "node:test";

import { guessWords } from "../../../static/js/replay/guess.js";

test("a guess is right, or off by a number of bins", () => {
  assert.equal(guessWords(3, 3), " Your guess was right.");
  assert.equal(guessWords(4, 3), " Your guess was bin 4: 1 bin off.");
  assert.equal(guessWords(0, 3), " Your guess was bin 0: 3 bins off.");
});

test("without a guess or a bin nothing is said", () => {
  assert.equal(guessWords(null, 3), "");
  assert.equal(guessWords(3, null), "");
});
