// Undo and redo of an edited board.

import assert from "node:assert/strict";
import { test } from "node:test";

import { EditHistory } from "../../../../static/js/editor/draft/history.js";

test("undo and redo are inverse, and a change clears redo", () => {
  const [a, b, c, d] = ["a", "b", "c", "d"].map((name) => ({ name }));
  const history = new EditHistory(a);
  assert.deepEqual([history.travel("undo"), history.travel("redo")], [false, false]);
  for (const board of [b, c, c]) history.push(board);
  assert.deepEqual([history.travel("undo"), history.board], [true, b]);
  assert.deepEqual([history.travel("undo"), history.board], [true, a]);
  assert.equal(history.travel("undo"), false);
  assert.deepEqual([history.travel("redo"), history.board], [true, b]);
  history.push(d);
  assert.equal(history.canRedo, false);
  assert.deepEqual([history.travel("undo"), history.board], [true, b]);
});
