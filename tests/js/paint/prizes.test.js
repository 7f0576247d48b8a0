// Prizes are lettered whole where possible, in legible sizes and colours.

import assert from "node:assert/strict";
import { test } from "node:test";

import { coloursOf, inkOn, letteringOf, prizeOf } from "../../../static/js/paint/prizes.js";

const widthOf = (text) => 0.6 * text.length;
const boxes = (count, width, height) => Array.from({ length: count }, (_, i) => ({ x: i * width, y: 0, width, height }));

test("short prizes in wide bins are whole and horizontal", () => {
  const [one] = letteringOf(widthOf, ["Mug"], boxes(1, 120, 60));
  assert.deepEqual(one, { lines: ["Mug"], size: 24, along: false });
});

test("words are broken into lines before they are made small", () => {
  const [one] = letteringOf(widthOf, ["A trip to Lisbon"], boxes(1, 90, 90));
  assert.equal(one.lines.join(" "), "A trip to Lisbon");
  assert.ok(one.lines.length > 1 && one.size > 14);
});

test("in narrow bins prizes are turned, and cut to stay legible", () => {
  const texts = ["T-shirt", "Unpronounceablenessandmorethanthat", "Pen"];
  const letterings = letteringOf(widthOf, texts, boxes(3, 24, 80));
  assert.ok(letterings.every(({ along, size }) => along && size >= 9));
  assert.deepEqual(letterings[0].lines, ["T-shirt"]);
  assert.match(letterings[1].lines[0], /^Unp.*…$/);
  assert.ok(widthOf(letterings[1].lines[0]) * letterings[1].size <= 80);
});

test("ink is black on light colours and white on dark ones", () => {
  assert.deepEqual(["#ffffff", "#ffd700", "#00ff00", "#0000ff", "#222222"].map(inkOn),
    ["#000000", "#000000", "#000000", "#ffffff", "#ffffff"]);
});

test("a label without a colour has its payout's colour", () => {
  const payout = { from: 0, fill: "#111111", ink: "#eeeeee" };
  assert.equal(coloursOf({ text: "Mug" }, payout), payout);
  assert.equal(coloursOf(null, payout), payout);
  assert.deepEqual(coloursOf({ text: "Mug", colour: "#ffd700" }, payout), { fill: "#ffd700", ink: "#000000" });
});

test("a ball wins its bin's prize, or the multiplier", () => {
  const board = { bins: { y: 1, edges: [0, 1, 2], multipliers: [2, 0.5], labels: [{ text: "Mug" }, null] } };
  assert.deepEqual([prizeOf(board, 0, 2), prizeOf(board, 1, 0.5), prizeOf(null, 0, 2)], ["Mug", "0.5x", "2x"]);
});
