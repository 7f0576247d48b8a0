// The second ball of a comparison: from another seed, or from a start a little off the first.

import assert from "node:assert/strict";
import { test } from "node:test";

import { secondDrop } from "../../../static/js/replay/pair.js";

const board = /** @type {any} */ ({ drop: { x: 0, y: -0.5, jitter: 0.02, reach: 0.1, aim: 0.08 } });
const aimed = { board: "triangle-8", seed: "42", x: null, aim: "0.05" };

test("a moved start is explicit, without an aim", () => {
  const second = secondDrop(board, aimed, 0.051, "1e-3", null);
  assert.deepEqual(second, { ...aimed, x: 0.052, aim: null });
});

test("another seed draws around the same aim", () => {
  assert.deepEqual(secondDrop(board, aimed, 0.051, "bit", "7"), { ...aimed, seed: "7" });
});

test("another seed replaces an explicit start", () => {
  const given = { ...aimed, x: "0.01", aim: null };
  assert.deepEqual(secondDrop(board, given, 0.01, "bit", "7"), { ...given, seed: "7", x: null });
});

test("a start at the right end of the zone is moved to the left", () => {
  assert.equal(secondDrop(board, aimed, 0.1, "1e-3", null).x, 0.099);
});
