// Ghost trails add up the time that balls spend in each cell of a grid.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Density } from "../../../../static/js/play/show/density.js";
import { nearly } from "../../support.js";

test("ghost trails add up time on a grid of fixed size", () => {
  const density = new Density({ left: -4, right: 4, top: 0, bottom: 6 });
  const sum = () => density.cells.reduce((all, one) => all + one, 0);
  const law = { gravity: 0, drag: 0 };
  const place = (t, x, y) => ({ t, x, y, vx: 0, vy: 0, vIn: false, vOut: false });
  density.follow(place(0, -1, 1), place(1, 1, 1), law);
  const fast = sum();
  assert.ok(fast > 0);
  density.follow(place(0, -1, 3), place(3, 1, 3), law);
  const both = sum();
  nearly(both, 4 * fast, 1e-3);
  density.follow(place(0, -9, -9), place(1, -8, -9), law);
  assert.equal(sum(), both);
  assert.ok(density.cells.length > 200_000 && density.cells.length < 300_000);
});
