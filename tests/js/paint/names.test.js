// Names at balls: on one line or two, shortened at a word.

import assert from "node:assert/strict";
import { test } from "node:test";

import { linesOf, placeNames } from "../../../static/js/paint/names.js";

test("a short name has one line, a long one two", () => {
  assert.deepEqual(linesOf("Ada"), ["Ada"]);
  assert.deepEqual(linesOf("Ada Lovelace"), ["Ada Lovelace"]);
  assert.deepEqual(linesOf("Maximilian von Hohenberg"), ["Maximilian von", "Hohenberg"]);
});

test("a name that is too long for two lines ends at a word", () => {
  assert.deepEqual(linesOf("Bob the Builder of Big Boards"), ["Bob the", "Builder of Big…"]);
  assert.deepEqual(linesOf("xX_ThePlinkoMaster_2026_X"), ["xX_ThePlinkoM…"]);
  assert.deepEqual(linesOf("Jo ThePlinkoMaster_2026_X"), ["Jo", "ThePlinkoMast…"]);
});

test("an emoji of several parts is one letter", () => {
  const family = "\u{1f468}\u200d\u{1f469}\u200d\u{1f467}";
  assert.deepEqual(linesOf(family.repeat(14)), [family.repeat(14)]);
  assert.deepEqual(linesOf(family.repeat(15)), [`${family.repeat(13)}…`]);
});

const PICTURE = { width: 400, height: 300, reach: 10 };
const plate = (ball, x, y) => ({ ball, x, y, width: 80, height: 20, sheet: null });
const sidesOf = (placed) => [...placed].map(([ball, { side }]) => [ball, side]);

test("names never overlap: each takes a free side of its ball, or is left out", () => {
  const crowd = Array.from({ length: 7 }, (_, i) => plate(i, 200 + 3 * i, 150));
  const placed = placeNames(crowd, PICTURE, new Map());
  const boxes = [...placed.values()].map(({ box }) => box);
  assert.deepEqual(sidesOf(placed).slice(0, 2), [[0, 0], [1, 1]]);
  assert.ok(boxes.length < crowd.length);
  boxes.forEach((one, i) => boxes.slice(i + 1).forEach((two) => {
    assert.ok(Math.abs(one.x - two.x) >= 80 || Math.abs(one.y - two.y) >= 20);
  }));
});

test("a name stays on its side while it can, and within the picture", () => {
  const near = [plate(1, 200, 150), plate(2, 210, 150)];
  const first = placeNames(near, PICTURE, new Map());
  const apart = placeNames([plate(1, 100, 150), plate(2, 300, 150)], PICTURE, first);
  assert.deepEqual(sidesOf(apart), sidesOf(first));
  const [{ box }] = placeNames([plate(1, 5, 5)], PICTURE, new Map()).values();
  assert.deepEqual([box.x, box.y], [0, 0]);
});
