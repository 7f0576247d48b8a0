// Multipliers are lettered upright in their bins, however narrow these are.

import assert from "node:assert/strict";
import { test } from "node:test";

import { paintBins } from "../../../static/js/paint/board.js";
import { layOut } from "../../../static/js/paint/geometry.js";
import { triangle } from "../support.js";

/** The texts written on a fake canvas that can only write, fill and measure. */
function written(board, width) {
  const texts = [];
  const ctx = {
    font: "", beginPath() {}, roundRect() {}, fill() {},
    measureText: (text) => ({ width: 0.6 * parseFloat(ctx.font.split(" ")[1]) * text.length }),
    fillText: (text) => texts.push([text, parseFloat(ctx.font.split(" ")[1])]),
  };
  paintBins({ ctx, geometry: layOut(board, width), board, look: { payout: () => ({ fill: "", ink: "" }) } });
  return texts;
}

test("a label is on one line, without its x in a narrow bin", () => {
  const board = triangle();
  assert.deepEqual(written(board, 900).map(([text]) => text).slice(0, 3), ["10x", "3x", "1.5x"]);
  const narrow = written(board, 180);
  assert.deepEqual(narrow.map(([text]) => text).slice(0, 3), ["10", "3", "1.5"]);
});

test("an even number of bins is labelled, too", () => {
  const board = triangle();
  const multipliers = [...board.bins.multipliers, 10];
  board.bins = { ...board.bins, edges: [...board.bins.edges, board.bins.edges.at(-1) + 0.5], multipliers };
  assert.equal(written(board, 900).length, multipliers.length);
});

test("of very narrow bins that pay the same, some are labelled", () => {
  const board = triangle();
  const edges = Array.from({ length: 34 }, (_, i) => (i - 16.5) / 6);
  board.bins = { ...board.bins, edges, multipliers: edges.slice(1).map(() => 0.99) };
  const texts = written(board, 360);
  assert.ok(texts.length > 2 && texts.length < 20);
  for (const [text, size] of texts) assert.deepEqual([text, size >= 8.5], ["0.99x", true]);
});
