// A board fills its canvas in the same way whatever its size in metres.

import assert from "node:assert/strict";
import { test } from "node:test";

import { layOut, ratioOf, sides } from "../../../static/js/paint/geometry.js";
import { near, triangle } from "../support.js";

const WIDTH = 760; // CSS pixels

/** `board` in another size. */
function enlarged(board, by) {
  const times = (part) => Object.fromEntries(Object.entries(part).map(([key, value]) => [key, by * value]));
  return {
    ...board,
    ball: { ...board.ball, radius: by * board.ball.radius },
    pegs: board.pegs.map(times),
    walls: board.walls.map(times),
    bins: { ...board.bins, y: by * board.bins.y, edges: board.bins.edges.map((x) => by * x) },
    drop: { ...board.drop, x: by * board.drop.x, y: by * board.drop.y },
  };
}

/** @returns a triangle as wide as the presets, 7 m */
function usual() {
  const board = triangle();
  const { left, right } = sides(board);
  return enlarged(board, 7 / (right - left));
}

test("a small board and a large one fill the canvas as a preset does", () => {
  const preset = usual();
  const [last, plain] = [preset.bins.edges.length - 1, layOut(preset, WIDTH)];
  for (const width of [0.01, 0.1, 1, 100, 1000]) {
    const board = enlarged(preset, width / 7);
    const shown = layOut(board, WIDTH);
    near(shown.px(board.bins.edges[last]), plain.px(preset.bins.edges[last]), 8);
    near(shown.binTop, plain.binTop, 12);
    near(shown.binHeight, plain.binHeight, 8);
    near(shown.metre, plain.metre, 20);
    near(ratioOf(board), ratioOf(preset), 0.03);
  }
});

test("boards as wide as the presets have the same margins, in metres", () => {
  for (const width of [6.2, 7, 7.8]) {
    const board = enlarged(usual(), width / 7);
    const { left, right } = sides(board);
    const outermost = board.walls.flatMap((wall) => [wall.x1, wall.x2]);
    near(right - Math.max(...outermost), 0.08, 1e-9);
    near(Math.min(...outermost) - left, 0.08, 1e-9);
    const { scale, metre } = layOut(board, WIDTH);
    assert.equal(metre, scale);
  }
});
