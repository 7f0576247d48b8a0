// What this page has stored and cannot read counts as absent.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Visited } from "../../../static/js/model/player/visited.js";
import { keepToken, showingToken } from "../../../static/js/net/session-token.js";
import { Self } from "../../../static/js/play/account/self.js";
import { keepAim, keptAim } from "../../../static/js/play/desk/aim.js";
import { storage } from "../support.js";

const DAMAGED = ['{"half', "", "null", "5", "[1]", '{"rooms": 5}', '{"room": {}}', '[["a"]]'];

/** The same value under every key. */
const full = (text) => ({ ...storage(), getItem: () => text });

for (const text of DAMAGED) {
  test(`${text || "an empty text"} counts as absent`, () => {
    const kept = full(text);
    assert.deepEqual(new Visited(kept).rooms, {});
    assert.equal(new Visited(kept).room, "");
    assert.deepEqual(new Self(kept).appearance, {});
    assert.equal(keptAim(kept, "classic"), null);
    keepAim(kept, "classic", 0.5);
    keepToken(kept, "s", "t");
  });
}

test("a token is found, also one that release 1.0 has stored, and damaged lists count as absent", () => {
  const kept = storage();
  kept.setItem("plinko.tokens.1", '[["old", "t0"]]');
  keepToken(kept, "new", "t1");
  assert.equal(showingToken(kept, "old").headers.authorization, "Bearer t0");
  assert.equal(showingToken(kept, "new").headers.authorization, "Bearer t1");
  for (const damaged of DAMAGED) {
    kept.setItem("plinko.tokens.1", damaged);
    assert.deepEqual(showingToken(kept, "old"), {});
  }
  for (let i = 0; i < 250; i += 1) keepToken(kept, `s${i}`, "t");
  assert.deepEqual(showingToken(kept, "new"), {}, "only the latest are kept");
  assert.equal(showingToken(kept, "s249").headers.authorization, "Bearer t");
});
