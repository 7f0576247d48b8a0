// The sounds of places: all different, equally loud, and without overtones when voices are few.

import assert from "node:assert/strict";
import { test } from "node:test";

import { WORLDS } from "../../../../static/js/model/presets.js";
import { HOME, TIMBRES } from "../../../../static/js/play/sound/timbres.js";
import { chimeOf, chosen, toneOf, withOvertones } from "../../../../static/js/play/sound/tones.js";

const SIDES = { left: -1, right: 1 };
const hit = (timbre, x = 0) => toneOf({ kind: 0, speed: 2, x }, SIDES, timbre);

test("each place has its own sound, as loud as the others", () => {
  const [, ...away] = WORLDS;
  assert.deepEqual(Object.keys(TIMBRES), away);
  const tones = [HOME, ...Object.values(TIMBRES)].map((timbre) => hit(timbre));
  assert.equal(new Set(tones.map(({ frequency, decay }) => `${frequency} ${decay}`)).size, WORLDS.length);
  assert.equal(new Set(tones.map(({ gain }) => gain)).size, 1);
  for (const timbre of Object.values(TIMBRES)) {
    assert.ok(hit(timbre, 0.9).frequency > hit(timbre, -0.9).frequency, "higher on the right");
  }
});

test("if voices are few, overtones are left out", () => {
  const tones = [-0.5, 0.5].flatMap((x) => withOvertones(hit(TIMBRES.steel, x), TIMBRES.steel));
  assert.equal(tones.length, 6);
  assert.deepEqual(chosen(tones, 2).map(({ frequency }) => frequency), [tones[0].frequency, tones[3].frequency]);
});

test("a bin that pays little ticks, others ring by their payout", () => {
  assert.deepEqual([0.3, 1, 12, 130].map((score) => chimeOf(score, 0.5).length), [1, 2, 3, 4]);
  assert.ok(chimeOf(0.3, 0.5)[0].gain < chimeOf(1, 0.5)[0].gain);
});
