// Named players are ranked by name, in bounded memory.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Leaders, MOST_NAMES } from "../../../static/js/stage/leaders.js";

const BOARD = { bins: { y: 1, edges: [0, 1, 2], multipliers: [5, 1], labels: [{ text: "Mug" }, null] } };
const landing = (name, bin, score = bin === null ? 1 : BOARD.bins.multipliers[bin]) => (
  { mine: false, owner: { visitor: 1, ...(name && { name }) }, ball: {}, score, bin });

function names(leaders, rank, most = 5) {
  return leaders.top(rank, most).map(({ best }) => best.owner.name);
}

test("players are ranked by best drop, balls or prizes", () => {
  const leaders = new Leaders();
  for (const [name, bin] of [["Ada", 1], ["Ada", 1], ["Ada", 1], ["Ben", 0], ["Cem", 1], ["Cem", 1]]) {
    leaders.note(landing(name, bin), BOARD);
  }
  assert.deepEqual(names(leaders, "best"), ["Ben", "Ada", "Cem"]);
  assert.deepEqual(names(leaders, "balls"), ["Ada", "Cem", "Ben"]);
  assert.deepEqual(names(leaders, "prizes"), ["Ben"]);
  assert.deepEqual(names(leaders, "balls", 1), ["Ada"]);
});

test("a name is one player, also after a reconnect", () => {
  const leaders = new Leaders();
  leaders.note({ ...landing("Ada", 1), owner: { visitor: 1, name: "Ada" } }, BOARD);
  leaders.note({ ...landing("Ada", 1), owner: { visitor: 7, name: "Ada" } }, BOARD);
  assert.deepEqual(leaders.top("balls", 5).map(({ balls }) => balls), [2]);
});

test("guests, ownerless balls and void drops are not ranked", () => {
  const leaders = new Leaders();
  leaders.note(landing(null, 0), BOARD);
  leaders.note({ ...landing("Ada", 0), owner: null }, BOARD);
  leaders.note(landing("Ada", null), BOARD);
  assert.deepEqual(leaders.top("balls", 5), []);
});

test("of a hundred thousand names the last are kept", () => {
  const leaders = new Leaders();
  for (let i = 0; i < 100_000; i += 1) leaders.note(landing(`n${i}`, 1), BOARD);
  const known = leaders.top("balls", 100_000);
  assert.equal(known.length, MOST_NAMES);
  assert.ok(known.some(({ best }) => best.owner.name === "n99999"));
});
