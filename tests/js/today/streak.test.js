// The ball of the day: its seed, and the record of guesses.

import assert from "node:assert/strict";
import { test } from "node:test";

import { ballOfDay, isBook, marksOf, streakAt, untilNext, withGuess } from "../../../static/js/today/streak.js";

const DAY = 24 * 3600 * 1000;
const NOON = Date.parse("2027-01-01T12:00:00Z");

test("the ball of the day is the same everywhere, by UTC", () => {
  const ball = { board: "triangle-9", seed: "20270101" };
  assert.deepEqual(ballOfDay(Date.parse("2027-01-01T00:00:00Z")), ball);
  assert.deepEqual(ballOfDay(Date.parse("2027-01-02T01:59:59+02:00")), ball);
  assert.equal(ballOfDay(Date.parse("2027-01-02T00:00:00Z")).seed, "20270102");
  assert.equal(untilNext(NOON), DAY / 2);
});

test("a streak grows day by day, and ends with a missed day", () => {
  let book = withGuess(null, NOON, 4, 4);
  assert.deepEqual([book.streak, book.best, book.right, book.played], [1, 1, 1, 1]);
  book = withGuess(book, NOON + DAY, 2, 5);
  assert.deepEqual([book.streak, book.best, book.right, book.played], [2, 2, 1, 2]);
  assert.equal(streakAt(book, NOON + DAY), 2);
  assert.equal(streakAt(book, NOON + 2 * DAY), 2, "today's ball can still continue it");
  assert.equal(streakAt(book, NOON + 3 * DAY), 0);
  book = withGuess(book, NOON + 3 * DAY, 1, null);
  assert.deepEqual([book.streak, book.best, book.right, book.played], [1, 2, 1, 3]);
  assert.ok(isBook(JSON.parse(JSON.stringify(book))));
  assert.ok(!isBook({ ...book, streak: "2" }));
});

test("the shared marks tell how close a guess was, not where the ball lands", () => {
  assert.equal(marksOf({ guess: 3, bin: 3 }), "🎯");
  assert.equal(marksOf({ guess: 3, bin: 5 }), "🟡🟡🟡⚪⚪");
  assert.equal(marksOf({ guess: 5, bin: 3 }), "🟡🟡🟡⚪⚪");
  assert.equal(marksOf({ guess: 0, bin: 9 }), "⚪⚪⚪⚪⚪");
});
