// A mark stays a player's, in all their tabs, until they make another; nobody else has the same.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Mark } from "../../../../static/js/play/account/mark.js";
import { storage } from "../../support.js";

test("it is the same in all tabs until another is made", () => {
  const shared = storage();
  const first = new Mark(shared).value;
  assert.match(first, /^[0-9a-f]{32}$/);
  assert.equal(new Mark(shared).value, first);
  const second = new Mark(shared).renew();
  assert.notEqual(second, first);
  assert.equal(new Mark(shared).value, second);
});

test("no two players have the same", () => {
  const all = Array.from({ length: 100 }, () => new Mark(storage()).value);
  assert.equal(new Set(all).size, 100);
});
