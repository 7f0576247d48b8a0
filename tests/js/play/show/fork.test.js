// The impact that decided a drop is the last one that two nearby balls have in common.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { findFork } from "../../../../static/js/play/show/fork.js";
import { openSolver } from "../../../../static/js/solver/solver.js";
import { triangle } from "../../support.js";

const bytes = readFileSync(new URL("../../../../static/js/solver/kernels.wasm", import.meta.url));
const board = triangle();
const starts = { from: -0.25, to: 0.25 };

test("a drop's decisive impact is its last on the same pegs", async () => {
  const solver = await openSolver(bytes);
  const whole = solver.read(board);
  const dropAt = (x) => solver.drop(whole, { x });
  for (const seed of ["1", "2", "3", "42"]) {
    const drop = solver.drop(whole, { seed });
    const fork = findFork(drop, dropAt, starts);
    const shared = drop.impacts.findIndex(([t]) => t === fork.t);
    const near = (x) => dropAt(x).impacts.map((row) => `${row[6]} ${row[7]}`);
    const ours = drop.impacts.map((row) => `${row[6]} ${row[7]}`);
    const sides = [drop.xStart - fork.hair, drop.xStart + fork.hair].map(near);
    const theirs = sides.find((row) => row.slice(0, shared + 1).join() === ours.slice(0, shared + 1).join()
      && row[shared + 1] !== ours[shared + 1]);
    assert.ok(theirs, `seed ${seed}: the same up to impact ${shared}, then different`);
    const { x } = fork.path.at(-1);
    const bin = board.bins.edges.findIndex((edge, i) => x >= edge && x < board.bins.edges[i + 1]);
    assert.notEqual(bin, drop.bin);
    assert.equal(board.bins.multipliers[bin], fork.score);
  }
});

test("a drop whose bin no tiny shift changes has no fork", async () => {
  const solver = await openSolver(bytes);
  const whole = solver.read({ ...board, pegs: [] });
  const drop = solver.drop(whole, { x: 0.1 });
  assert.equal(findFork(drop, (x) => solver.drop(whole, { x }), starts), null);
});
