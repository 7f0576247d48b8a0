// The editor's model of a board: changes, the element at a place, and the elements of an error.

import assert from "node:assert/strict";
import { test } from "node:test";

import { complete, hit, read, refsInProblem, refsOf, snap, written } from "../../../../static/js/editor/draft/draft.js";
import { moved, withSplit, without } from "../../../../static/js/editor/draft/element.js";
import { triangle } from "../../support.js";

const BOARD = triangle();

for (const [form, named] of [
  [[], /object/],
  [{ pegs: 3 }, /pegs/],
  [{ pegs: [{ x: 1, y: "two", radius: 0.1 }] }, /not a number/],
  [{ bins: { edges: [0, 1, 0.5], multipliers: [1, 1] } }, /increase/],
  [{ bins: { edges: [0, 1], multipliers: [1, 1] } }, /one multiplier/],
]) {
  test(`an invalid board is refused: ${JSON.stringify(form)}`, () => {
    assert.throws(() => complete(form), (error) => error instanceof RangeError && named.test(error.message));
  });
}

test("a moved edge stays between its neighbours", () => {
  for (const x of [-100, 100]) {
    const { edges } = moved(BOARD, { kind: "edge", index: 3 }, x, 0).bins;
    edges.slice(1).forEach((edge, i) => assert.ok(edge > edges[i]));
  }
});

test("a bin can be divided and joined again", () => {
  const { edges, multipliers: pays } = BOARD.bins;
  const middle = (edges[2] + edges[3]) / 2;
  const split = withSplit(BOARD, middle);
  assert.deepEqual(split.ref, { kind: "edge", index: 3 });
  assert.equal(split.board.bins.edges[3], middle);
  assert.deepEqual(split.board.bins.multipliers, [...pays.slice(0, 3), pays[2], ...pays.slice(3)]);
  assert.deepEqual(without(split.board, split.ref), BOARD);
});

test("a prize exists while it has a text, and stays at its bin", () => {
  const [text, colour] = ["text", "colour"].map((part) => `bins.labels[2].${part}`);
  const named = written(BOARD, text, "T-shirt");
  assert.deepEqual(named.bins.labels, BOARD.bins.multipliers.map((_, bin) => (bin === 2 ? { text: "T-shirt" } : null)));
  const coloured = written(named, colour, "#ff0088");
  assert.deepEqual(coloured.bins.labels[2], { text: "T-shirt", colour: "#ff0088" });
  assert.deepEqual(written(coloured, colour, ""), named);
  assert.deepEqual(written(coloured, text, ""), BOARD, "without prizes a board has no labels");
  assert.equal(without(named, { kind: "bin", index: 0 }).bins.labels[1].text, "T-shirt");
  assert.deepEqual(without(named, { kind: "bin", index: 2 }).bins.labels, undefined);
  const split = withSplit(named, BOARD.bins.edges[0] - 1);
  assert.equal(split.board.bins.labels.length, split.board.bins.multipliers.length);
  assert.equal(split.board.bins.labels[3].text, "T-shirt");
  assert.throws(() => complete({ ...BOARD, bins: { ...BOARD.bins, labels: [null] } }), RangeError);
});

test("each bin has one multiplier, and the last bin stays", () => {
  let board = BOARD;
  let turns = 0;
  for (; turns < 50; turns += 1) {
    const refs = refsOf(board).filter(({ kind }) => kind === "edge" || kind === "bin");
    const next = without(board, refs[(turns * 7) % refs.length]);
    if (!next) break;
    board = next;
    const { edges, multipliers } = board.bins;
    assert.equal(edges.length, multipliers.length + 1);
    edges.slice(1).forEach((edge, i) => assert.ok(edge > edges[i]));
  }
  assert.equal(turns, BOARD.bins.multipliers.length - 1);
});

test("the smallest element under the pointer is found", () => {
  const { walls: [wall], bins: { edges, y }, pegs, drop } = BOARD;
  for (const [ref, x, atY] of [
    [{ kind: "peg", index: 7 }, pegs[7].x + 0.01, pegs[7].y],
    [{ kind: "wall", index: 0, end: 1 }, wall.x1, wall.y1 + 0.005],
    [{ kind: "wall", index: 0 }, (wall.x1 + wall.x2) / 2, (wall.y1 + wall.y2) / 2],
    [{ kind: "edge", index: 4 }, edges[4] + 0.01, y + 0.2],
    [{ kind: "bin", index: 4 }, (edges[4] + edges[5]) / 2, y + 0.2],
    [{ kind: "drop", index: 0 }, drop.x, drop.y],
    [null, wall.x1 - 3, 1],
  ]) {
    assert.deepEqual(hit(BOARD, x, atY, 0.03), ref);
  }
});

test("snapped coordinates are short decimals", () => {
  const values = [0.3000001, 0.1 + 0.2, -0.149, 1.0249];
  assert.deepEqual(values.map((value) => snap(value, 0.05)), [0.3, 0.3, -0.15, 1]);
  assert.deepEqual(values.map((value) => snap(value, 0)), values);
});

test("a value is written only at its path", () => {
  const before = JSON.stringify(BOARD);
  const next = written(written(BOARD, "pegs[3].x", 9), "ball.radius", 0.5);
  const wanted = JSON.parse(before);
  wanted.pegs[3].x = 9;
  wanted.ball.radius = 0.5;
  assert.deepEqual(next, wanted);
  assert.equal(read(next, "pegs[3].x"), 9);
  assert.equal(read(next, "drop.reach"), undefined);
  assert.equal(JSON.stringify(BOARD), before);
});

for (const [field, detail, wanted] of [
  ["pegs[3].radius", "pegs[3].radius is 0", [["peg", 3]]],
  ["pegs[5]", "pegs[5] at (1, 1) overlaps pegs[2] at (1, 1)", [["peg", 5], ["peg", 2]]],
  ["walls[1]", "walls[1] has no length", [["wall", 1]]],
  ["bins.edges[8]", "a ball can miss the bins", [["edge", 8]]],
  ["drop.y", "the start must be above the bins", [["drop", 0]]],
  ["ball.radius", "the ball cannot pass", []],
  ["pegs[999]", "no such peg is drawn", []],
  [null, "busy", []],
]) {
  test(`an error leads to its elements: ${field}`, () => {
    const found = refsInProblem(BOARD, field, detail);
    assert.deepEqual(found.map(({ kind, index }) => [kind, index]), wanted);
  });
}
