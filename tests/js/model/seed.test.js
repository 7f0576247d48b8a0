// A seed keeps its last digit, and an invalid one is refused with its text.

import assert from "node:assert/strict";
import { test } from "node:test";

import { readSeed, seedAfter } from "../../../static/js/model/seed.js";

const LARGEST = "18446744073709551615";

for (const text of ["-1", "18446744073709551616", "abc", "1.5", "1e3", "0x10", "NaN",
  "9".repeat(400), "１２"]) {
  test(`an invalid seed is refused: ${text.slice(0, 24)}`, () => {
    const reading = readSeed(text);
    assert.equal(reading.ok, false);
    assert.ok(reading.message.includes(text.slice(0, 20)));
    assert.ok(reading.message.includes(LARGEST));
  });
}

test("a seed keeps every digit", () => {
  const wanted = { [LARGEST]: LARGEST, " 9007199254740993 ": "9007199254740993", 0: "0", "007": "7" };
  for (const [typed, seed] of Object.entries(wanted)) assert.deepEqual(readSeed(typed), { ok: true, seed });
});

test("an empty field is valid, and gives no seed", () => {
  assert.deepEqual(readSeed("  "), { ok: true, seed: null });
});

test("after the largest seed comes the smallest", () => {
  assert.equal(seedAfter("41"), "42");
  assert.equal(seedAfter(LARGEST), "0");
});
