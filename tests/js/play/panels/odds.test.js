// The odds that are shown belong to the current table, even if the server answers late.

import assert from "node:assert/strict";
import { test } from "node:test";

import { showOdds } from "../../../../static/js/play/panels/odds.js";
import { storage } from "../../support.js";

const odds = (bins) => ({
  return: 0.99, aim: null, awards: [{ multiplier: 9, chance: 0.01 }], chances: Array(bins).fill(1 / bins),
});
const hello = (name, digest) => ({
  board_name: name, board_digest: digest, mode: "independent", board: { drop: { x: 0 } },
});

/** A page whose server answers when the test wants. */
function page(t) {
  const replies = new Map();
  const note = { textContent: "" };
  const before = { document: globalThis.document, window: globalThis.window, fetch: globalThis.fetch };
  t.after(() => Object.assign(globalThis, before));
  globalThis.document = { baseURI: "http://here/", getElementById: () => note };
  globalThis.window = { localStorage: storage() };
  globalThis.fetch = (url) => new Promise((answer) => {
    const [name] = url.pathname.split("/").slice(-2);
    replies.set(name, (body) => answer(new Response(JSON.stringify(body))));
  });
  const heard = {};
  const told = [];
  const game = {
    room: { hello: null }, choice: { aim: null }, odds: null,
    on: (kind, listen) => { heard[kind] = listen; },
    tell: (_, found) => told.push(found),
  };
  showOdds(game);
  const enter = (to) => {
    game.room.hello = to;
    heard.table({ hello: to });
  };
  return { game, heard, note, replies, told, enter };
}

const turns = async () => { for (let i = 0; i < 20; i += 1) await new Promise(setImmediate); };

test("the previous table's odds are not shown for the next", async (t) => {
  const { game, heard, note, replies, told, enter } = page(t);
  enter(hello("triangle-12", "d12"));
  game.room.hello = null; // the player has left, and the next table has not sent its hello yet
  replies.get("triangle-12")({ board_digest: "d12", aims: [odds(13)] });
  await turns();
  game.room.hello = hello("triangle-8", "d8");
  heard.choice(); // as if another panel were notified of the table first
  assert.equal(told.at(-1) ?? null, null);
  assert.equal(note.textContent, "");
  enter(game.room.hello);
  replies.get("triangle-8")({ board_digest: "d8", aims: [odds(9)] });
  await turns();
  assert.equal(told.at(-1).chances.length, 9);
  assert.match(note.textContent, /Average return 99/);
});
