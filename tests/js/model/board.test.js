// Where a ball may start.

import assert from "node:assert/strict";
import { test } from "node:test";

import { allowedStart } from "../../../static/js/model/board.js";

test("a start is kept inside what the board allows", () => {
  const jitter = 0.30870588235294116;
  const board = { drop: { x: 0, jitter } };
  for (const x of [-5, -0.3087059, jitter, 0.31, 5]) {
    assert.ok(Math.abs(allowedStart(board, [], x)) <= jitter, `${x}`);
  }
  assert.equal(allowedStart(board, [], 0.12345), 0.1234);
  const wide = { drop: { x: 0, jitter: 0.1, reach: 0.5 } };
  assert.equal(allowedStart(wide, [], 5), 0.5);
  assert.equal(allowedStart(wide, [-1.5, 0.25, 1.5], 0.8), 0.25);
});
