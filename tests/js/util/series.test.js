// Measurements in bounded memory.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Series } from "../../../static/js/util/series.js";

test("a series of any length fits its memory", () => {
  const series = new Series(["t", "v"], 64);
  for (let i = 0; i < 5000; i += 1) series.add({ t: i, v: 2 * i });
  const { rows } = series;
  assert.ok(series.count >= 32 && series.count <= 64, `${series.count}`);
  assert.ok(rows.every(({ t, v }) => v === 2 * t));
  assert.ok(rows.at(-1).t > 4700);
});
