// Boards in links: unpacking restores the board, and a broken link is an error.

import assert from "node:assert/strict";
import { test } from "node:test";
import { deflateRawSync } from "node:zlib";

import { boardInHash, LinkError, packBoard, unpackBoard } from "../../../static/js/net/board-link.js";
import { triangle } from "../support.js";

const unread = (error) => error instanceof LinkError && /cannot be read/.test(error.message);

test("a board survives a link, which is short and plain", async () => {
  const board = { ...triangle(), name: "Brett “ß” 木" };
  const packed = await packBoard(board);
  assert.deepEqual(await unpackBoard(boardInHash(`#board=${packed}`)), board);
  assert.match(packed, /^[A-Za-z0-9_-]+$/);
  assert.ok(packed.length < 0.6 * JSON.stringify(board).length);
});

test("an address without a board gives none", () => {
  assert.equal(boardInHash(""), null);
  assert.equal(boardInHash("#seed=1"), null);
});

for (const text of ["", "!!", "AAAA", "7cExAQ", "x".repeat(5000)]) {
  test(`a broken link is an error: ${text.slice(0, 8)}`, async () => {
    await assert.rejects(unpackBoard(text), unread);
  });
}

test("a link whose board has a member twice is broken", async () => {
  const packed = (text) => deflateRawSync(text).toString("base64url");
  assert.deepEqual(await unpackBoard(packed('{"width":8,"height":6}')), { width: 8, height: 6 });
  await assert.rejects(unpackBoard(packed('{"width":8,"width":6}')), unread);
});

test("a link that would unpack to gigabytes is refused", async () => {
  const packed = await packBoard({ name: "0".repeat(5_000_000) });
  await assert.rejects(unpackBoard(packed), unread);
});
