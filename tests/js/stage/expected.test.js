// The expectation of an ideal Galton board: the binomial law for the number of bins.

import assert from "node:assert/strict";
import { test } from "node:test";

import { binomial, expectedOn } from "../../../static/js/stage/expected.js";
import { near } from "../support.js";

test("after two rows the middle is twice as likely as a side", () => {
  assert.deepEqual(binomial(3).chances, [0.25, 0.5, 0.25]);
  assert.deepEqual(binomial(1).chances, [1]);
});

test("bins' chances are symmetric, add up, and are binomial", () => {
  const { chances } = binomial(17);
  near(chances.reduce((sum, chance) => sum + chance, 0), 1, 1e-12);
  near(chances.reduce((sum, chance, bin) => sum + chance * (bin - 8) ** 2, 0), 16 / 4, 1e-12);
  assert.deepEqual(chances, [...chances].reverse());
});

test("in a room with a draw the published weights are expected", async () => {
  const room = { board: { bins: { multipliers: [1, 1, 1] } }, board_name: "triangle-8", board_digest: "", draw: { weights: [1, 0, 3] } };
  for (const theory of ["on", "binomial"]) {
    assert.deepEqual((await expectedOn(room, theory)).chances, [0.25, 0, 0.75]);
  }
});
