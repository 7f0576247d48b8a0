// Auto-drop ends when so much was won or lost on what has landed since it began.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Dropper } from "../../../../static/js/play/input/dropper.js";

const NEVER = Number.POSITIVE_INFINITY;
const ask = () => ({ seed: null, aim: null, stake: 1 });

/** A dropper that has begun, and which is stopped after the test. */
function begun(t, limits) {
  const dropper = new Dropper({ hasRoom: () => true, onDrop: () => true, onAuto: () => {} });
  dropper.start(1, NEVER, ask, limits);
  t.after(() => dropper.stop());
  return dropper;
}

test("a win ends it, once it is as large as was said", (t) => {
  const dropper = begun(t, { win: 3, loss: NEVER });
  assert.equal(dropper.landed({ stake: 2, score: 2 }), null);
  assert.equal(dropper.landed({ stake: 1, score: 0 }), null);
  assert.equal(dropper.running, true);
  assert.equal(dropper.landed({ stake: 2, score: 2 }), 3);
  assert.equal(dropper.running, false);
  assert.equal(dropper.landed({ stake: 2, score: 0 }), null, "what lands later ends nothing");
});

test("a loss ends it, practice does not count, and each begins at nothing", (t) => {
  const dropper = begun(t, { win: NEVER, loss: 1.5 });
  assert.equal(dropper.landed({ score: 0 }), null);
  assert.equal(dropper.landed({ score: 0, practice: true }), null);
  dropper.start(1, NEVER, ask, { win: NEVER, loss: 1.5 });
  assert.equal(dropper.landed({ score: 0 }), null);
  assert.equal(dropper.landed({ score: 0.5 }), -1.5);
});
