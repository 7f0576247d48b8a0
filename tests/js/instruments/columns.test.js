// A pile's columns: discs fit the columns and the tray, and a disc represents as few balls as possible.

import assert from "node:assert/strict";
import { test } from "node:test";

import {
  discsOf, fittedEntry, LARGE_DISCS, placeOf, planOf, shareFor, trayGeometry, usualEntry,
} from "../../../static/js/instruments/pile/columns.js";
import { layOut } from "../../../static/js/paint/geometry.js";
import { triangle } from "../support.js";

const BOARD = triangle();

/** @param {number} width of the board @param {number} height of the tray, CSS pixels */
const planFor = (width, height, board = BOARD, wide = width) =>
  planOf(board, trayGeometry(board, layOut(board, width), wide), height);

for (const [width, height] of [[360, 27], [390, 64], [700, 72], [1600, 88], [60, 27]]) {
  test(`discs fit into a tray of ${width} x ${height} pixels`, () => {
    const plan = planFor(width, height);
    assert.equal(plan.room.length, BOARD.bins.multipliers.length);
    plan.room.forEach((room, bin) => {
      const wide = plan.edges[bin + 1] - plan.edges[bin];
      assert.ok(2 * plan.radius < wide && 2 * plan.radius < plan.height);
      assert.ok(room >= 1 && room * Math.PI * plan.radius ** 2 < wide * plan.height, `${room}`);
    });
  });
}

test("discs for an audience are as large as their columns allow", () => {
  const [small, large] = [undefined, LARGE_DISCS].map((sizes) => planOf(BOARD, { ...layOut(BOARD, 900), spread: 1 }, 360, sizes));
  assert.ok(large.radius > 2 * small.radius, `${large.radius} m, ${small.radius} m`);
  assert.ok(large.room.every((room, bin) => room > 10 && room < small.room[bin]), String(large.room));
});

test("a wall stands between columns, up to where discs enter", () => {
  const plan = planFor(700, 72);
  const { walls } = placeOf(plan);
  const upright = walls.filter(({ x1, x2 }) => x1 === x2);
  assert.deepEqual(upright.map(({ x1 }) => x1), plan.edges);
  assert.ok(upright.every(({ y1, y2 }) => y1 < plan.entry && y2 === plan.height));
  assert.ok(plan.entry < -plan.radius, "it enters above the tray");
});

test("in a tray wider than its board the columns fan out to the sides", () => {
  const plan = planFor(700, 144, BOARD, 900);
  const { walls } = placeOf(plan);
  const scale = layOut(BOARD, 700).scale;
  plan.edges.forEach((edge, i) => {
    const above = walls.find(({ x1, y1 }) => x1 === edge && y1 < plan.entry);
    assert.deepEqual([above.x2, above.y2 === plan.height], [edge, plan.floors[i] === edge], "straight down from the bin");
    assert.ok(walls.some(({ x2, y2 }) => x2 === plan.floors[i] && y2 === plan.height), "to the floor");
  });
  const wide = (plan.floors.at(-1) - plan.floors[0]) * scale;
  assert.ok(wide > 850 && wide <= 900, `${wide}`);
  const narrow = planFor(700, 144);
  assert.deepEqual(narrow.floors, narrow.edges);
  assert.ok(plan.room.every((room, bin) => room > narrow.room[bin]), "more discs fit");
});

test("discs have a gravity at which they come to rest", () => {
  const gravities = [0.001, 1.62, 9.81, 24.79, 90].map((gravity) => planFor(700, 72, { ...BOARD, gravity }).gravity);
  assert.deepEqual(gravities.slice(1, 4), [1.62, 9.81, 24.79]);
  assert.ok(gravities[0] > 1 && gravities[4] < 90);
});

test("a disc represents the fewest of 1, 2, 5, 10, … that fit", () => {
  const plan = { room: [10, 10, 10] };
  assert.equal(shareFor([0, 0, 0], plan), 1);
  assert.equal(shareFor([10, 3, 0], plan), 1);
  assert.equal(shareFor([11, 3, 0], plan), 2);
  assert.equal(shareFor([22, 3, 0], plan), 5);
  assert.equal(shareFor([1_000_000, 3, 0], plan), 100_000);
  assert.equal(shareFor([1, 0, 0], plan, 3), 5, "not fewer than required");
  const many = { room: Array.from({ length: 30 }, () => 100) };
  const counts = many.room.map(() => 99);
  const discs = discsOf(counts, shareFor(counts, many)).reduce((sum, count) => sum + count, 0);
  assert.ok(discs > 100 && discs < 300, `${discs} discs look like a pile and can be moved`);
});

test("a disc enters within its column, downwards", () => {
  const plan = planFor(700, 72);
  for (const [bin, x, speed] of [[0, -99, 0], [8, 99, 3], [4, 0.1, 2]]) {
    const entry = fittedEntry(plan, bin, { x, speed });
    assert.ok(entry.x - plan.radius > plan.edges[bin] && entry.x + plan.radius < plan.edges[bin + 1]);
    assert.ok(entry.speed > 0 && entry.speed >= speed);
  }
  assert.deepEqual(fittedEntry(plan, 4, { x: 0.1, speed: 2 }), { x: 0.1, speed: 2 });
  const [one, two] = [usualEntry(plan, 4, 0), usualEntry(plan, 4, 1)];
  assert.notEqual(one.x, two.x);
  assert.deepEqual(usualEntry(plan, 4, 1), two);
});
