// The light of a bin that a ball has hit.

import assert from "node:assert/strict";
import { test } from "node:test";

import { beamHeight, pulseOf } from "../../../static/js/paint/bin.js";

test("a bin that pays more shines more", () => {
  const scores = [0.2, 1, 10, 1000];
  const pulses = scores.map((score) => pulseOf(score, 0));
  const beams = pulses.map((pulse) => beamHeight({ height: 40 }, pulse));
  pulses.slice(1).forEach(({ strength }, i) => assert.ok(strength >= pulses[i].strength));
  beams.slice(1).forEach((beam, i) => assert.ok(beam >= beams[i]));
  assert.ok(pulses[0].strength < 0.05);
  assert.equal(pulses.at(-1).strength, 1);
  for (const score of scores) assert.equal(pulseOf(score, 1).glow, 0);
});
