// Balls: which stamps are copied to where, and the outline of a trail.

import assert from "node:assert/strict";
import { test } from "node:test";

import { fillTrail, paintFlash, paintLight } from "../../../static/js/paint/ball.js";
import { chance, near } from "../support.js";

/** Records the copies on a canvas: from where on the sheet, to where on the picture. */
function copies() {
  const told = [];
  const drawImage = (_, sx, sy, sw, sh, x, y, width, height) => {
    told.push({ sx, sy, sw, sh, x, y, width, height });
  };
  return { told, ctx: { drawImage } };
}

const stamp = (side, density) => ({ sheet: {}, side, density, half: side / density / 2 });

test("light is moved by at most half a pixel, to whole pixels", () => {
  const random = chance(7);
  for (const density of [1, 1.25, 2, 3]) {
    for (const side of [26, 79]) {
      const { told, ctx } = copies();
      const light = stamp(side, density);
      const [x, y] = [500 * random(), 500 * random()];
      paintLight(ctx, light, x, y);
      const [copy] = told;
      near(copy.x * density, Math.round(copy.x * density), 1e-9);
      near(copy.y * density, Math.round(copy.y * density), 1e-9);
      near(copy.width * density, side, 1e-9);
      near((copy.x + light.half) * density, x * density, 0.5);
      near((copy.y + light.half) * density, y * density, 0.5);
    }
  }
});

test("a flash is chosen by age and strength of the impact", () => {
  const flashes = { ...stamp(40, 2), radius: 4 };
  const at = (age, strength, radius = 4) => {
    const { told, ctx } = copies();
    paintFlash(ctx, flashes, 100, 100, radius, age, strength);
    return told[0];
  };
  assert.equal(at(0, 0).sx, 0);
  assert.ok(at(0.5, 0).sx > at(0.2, 0).sx);
  assert.equal(at(0.999, 0).sx, at(1, 0).sx);
  const rows = [0, 0.25, 0.5, 0.75, 1].map((strength) => at(0, strength).sy / 40);
  assert.deepEqual(rows, [0, 1, 2, 3, 4]);
  assert.equal(at(0, 1).width, 20);
  assert.equal(at(0, 1, 8).width, 40, "the flash is proportional to the peg");
});

test("a trail has the given width at the ball, and a pointed end", () => {
  const outline = [];
  const ctx = {
    beginPath: () => (outline.length = 0),
    lineTo: (x, y) => outline.push([x, y]),
    fill: () => outline.push("filled"),
  };
  fillTrail(ctx, [30, 20, 10, 0].map((x) => ({ x, y: 5 })), 3);
  assert.equal(outline.pop(), "filled");
  assert.deepEqual([outline[0], outline.at(-1)], [[30, 2], [30, 8]]);
  assert.deepEqual(outline.filter(([x]) => x === 0), [[0, 5]]);
  outline.length = 0;
  fillTrail(ctx, [30, 20].map((x) => ({ x, y: 5 })), 3);
  assert.deepEqual(outline, [], "two points are too few for a trail");
});
