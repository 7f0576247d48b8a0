// A whole path, as players with reduced motion see it after the landing.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Trace } from "../../../../static/js/model/motion/trace.js";

test("a whole path keeps its corners in bounded memory", () => {
  const trace = new Trace();
  const corner = { vx: 0, vy: 0, vIn: false, vOut: false };
  for (let i = 0; i < 6000; i += 1) {
    const x = i % 2;
    trace.follow({ t: i, x, y: i, ...corner }, { t: i + 1, x: 1 - x, y: i + 1, ...corner },
      { gravity: 0, drag: 0 });
  }
  assert.ok(trace.points.length >= 1024 && trace.points.length <= 2048, `${trace.points.length}`);
  assert.deepEqual(trace.points.at(-1), { x: 0, y: 6000 });
});
