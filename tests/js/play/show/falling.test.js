// A ball's fall in a few words, and near misses.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Falling, nearMiss } from "../../../../static/js/play/show/falling.js";

const board = {
  ball: { radius: 0.1 },
  pegs: Array.from({ length: 8 }, (_, row) => ({ x: 0, y: row, radius: 0.05 })),
  bins: { y: 8, edges: [-1, 0, 1], multipliers: [0.5, 20] },
};
const ball = (y, id = 1, mine = true) => ({ id, mine, x: 0.5, y });

test("a fall has four messages at any frame rate", () => {
  const falling = new Falling();
  falling.setBoard(board);
  const told = [];
  for (let y = -1; y < 9; y += 0.01) told.push(falling.words([ball(y)]));
  assert.deepEqual(told.filter((words) => words !== null), [
    "Falling…", "Row 3 of 8, above 20x…", "Row 5 of 8, above 20x…", "Row 7 of 8, above 20x…",
  ]);
  assert.equal(falling.words([ball(-1, 2)]), "Falling…", "the next ball begins again");
});

test("others' balls, and several own balls, have no messages", () => {
  const falling = new Falling();
  falling.setBoard(board);
  assert.equal(falling.words([ball(0, 1, false)]), null);
  assert.equal(falling.words([ball(0), ball(1, 2)]), null);
  assert.notEqual(falling.words([ball(0), ball(1, 2, false)]), null);
});

test("a near miss is shown only next to a bin that pays much more", () => {
  assert.equal(nearMiss(board, 0, -0.0123), "Just missed 20x");
  assert.equal(nearMiss(board, 0, -0.06), "", "more than half a radius away");
  assert.equal(nearMiss(board, 1, 0.001), "", "the missed bin pays less");
});

test("a fall has no messages while another message is shown", () => {
  const falling = new Falling();
  falling.setBoard(board);
  falling.silent = true;
  assert.equal(falling.words([ball(0)]), null);
  falling.silent = false;
  assert.notEqual(falling.words([ball(0)]), null);
});
