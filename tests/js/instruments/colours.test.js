// The colours of the balls in a bin: in the order of landing, also after reconnects and resets.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Colours } from "../../../static/js/instruments/colours.js";

/** @param {Colours} colours @param {number} bin @param {number} balls */
const inBin = (colours, bin, balls) => Array.from({ length: balls }, (_, ball) => colours.of(bin, ball));

test("a ball has its colour, an earlier landing has none", () => {
  const colours = new Colours();
  colours.fit([2, 0]);
  colours.add(0, "red");
  colours.add(1, "blue");
  assert.deepEqual([inBin(colours, 0, 3), inBin(colours, 1, 1)], [[null, null, "red"], ["blue"]]);
});

test("after a reconnect balls keep their colours", () => {
  const colours = new Colours();
  colours.fit([0, 0]);
  colours.add(0, "red");
  colours.fit([2, 1]);
  colours.add(0, "blue");
  assert.deepEqual([inBin(colours, 0, 3), inBin(colours, 1, 1)], [["red", null, "blue"], [null]]);
});

test("a room that restarts forgets the balls before", () => {
  for (const counts of [[0, 1], [9, 9, 9]]) {
    const colours = new Colours();
    colours.fit([0, 0]);
    colours.add(0, "red");
    colours.fit(counts);
    assert.deepEqual(counts.map((count, bin) => inBin(colours, bin, count)), counts.map((n) => Array(n).fill(null)));
  }
});

test("a colour's share of a bin is its number of balls", () => {
  const colours = new Colours();
  colours.fit([1]);
  for (const colour of ["red", "blue", "red"]) colours.add(0, colour);
  assert.deepEqual(colours.sharesOf(0), [
    { colour: null, balls: 1 }, { colour: "red", balls: 2 }, { colour: "blue", balls: 1 },
  ]);
});
