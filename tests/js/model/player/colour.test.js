// The default colours of players.

import assert from "node:assert/strict";
import { test } from "node:test";

import { colourOf, COLOURS } from "../../../../static/js/model/player/colour.js";
import { chance } from "../../support.js";

test("a player has one colour, and colours are equally frequent", () => {
  const next = chance(1);
  const counts = new Map(COLOURS.map((colour) => [colour, 0]));
  for (let i = 0; i < 5000; i += 1) {
    const who = Math.floor(next() * 2 ** 32).toString(16);
    const colour = colourOf(who);
    assert.equal(colour, colourOf(who));
    counts.set(colour, (counts.get(colour) ?? NaN) + 1);
  }
  for (const [colour, count] of counts) assert.ok(Math.abs(count - 500) < 100, `${colour}: ${count}`);
});
