// Measurements in bounded memory.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Series } from "../../../static/js/util/series.js";

test("a series of any length fits its memory", () => {
  const series = new Series(["t", "v"], 64);
  for (let i = 0; i < 5000; i += 1) series.add({ t: i, v: 2 * i });
  const points = series.points("t", "v");
  assert.ok(series.count >= 32 && series.count <= 64, `${series.count}`);
  assert.ok(points.every(({ x, y }) => y === 2 * x));
  assert.ok(points.at(-1).x > 4700);
});
