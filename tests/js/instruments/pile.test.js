// The pile in the tray: its discs fall and come to rest, always in the same way, and represent all landed balls.

import assert from "node:assert/strict";
import { test } from "node:test";

import { planOf, usualEntry } from "../../../static/js/instruments/pile/columns.js";
import { Heap } from "../../../static/js/instruments/pile/heap.js";
import { Pile } from "../../../static/js/instruments/pile/pile.js";
import { layOut } from "../../../static/js/paint/geometry.js";
import { SOLVER } from "../../../static/js/solver/touching/values.js";
import { triangle } from "../support.js";
import { machine } from "./machine.js";

const BOARD = triangle();
const GEOMETRY = { ...layOut(BOARD, 700), spread: 1 };
const HEIGHT = 72; // CSS pixels
const PLAN = planOf(BOARD, GEOMETRY, HEIGHT);
const COUNTS = [0, 2, 6, 12, 15, 11, 7, 1, 0];
const STEP = SOLVER.dt;
const MOST_STEPS = 3000; // far more than any pile needs to come to rest

/** @param {Heap} heap @returns {number} steps until all discs were at rest */
function settle(heap) {
  let steps = 0;
  for (; heap.runs && steps < MOST_STEPS; steps += 1) heap.step();
  assert.ok(steps < MOST_STEPS, "it comes to rest");
  return steps;
}

/** @param {Heap} heap */
const discsIn = (heap) => heap.look(1);

/** @param {number[]} counts @param {Plan} [plan] */
function filled(counts, plan = PLAN) {
  const heap = new Heap(machine, plan);
  counts.forEach((count, bin) => {
    for (let disc = 0; disc < count; disc += 1) heap.add(bin, usualEntry(plan, bin, disc));
  });
  return heap;
}

test("discs pile up in their columns, and at rest cost nothing", () => {
  const heap = filled(COUNTS);
  settle(heap);
  const discs = discsIn(heap);
  const { radius, edges, height } = PLAN;
  const near = 0.05 * radius;
  COUNTS.forEach((count, bin) => assert.equal(discs.filter((disc) => disc.bin === bin).length, count));
  for (const { bin, x, y } of discs) {
    assert.ok(x > edges[bin] + radius - near && x < edges[bin + 1] - radius + near, "between its walls");
    assert.ok(y > 0 && y < height - radius + near, "on the floor or above it");
  }
  discs.forEach((one, i) => {
    for (const two of discs.slice(i + 1)) {
      assert.ok(Math.hypot(one.x - two.x, one.y - two.y) > 2 * radius - near, "they do not overlap");
    }
  });
  assert.ok(discs.some(({ y }) => y < height - 3 * radius), "some lie on others");
  assert.equal(heap.runs, false);
});

test("discs in columns that fan out come to rest between their walls", () => {
  const plan = planOf(BOARD, { ...GEOMETRY, spread: 1.6 }, 2 * HEIGHT);
  const heap = filled(COUNTS, plan);
  settle(heap);
  const { radius, edges, floors, height } = plan;
  for (const { bin, x, y } of discsIn(heap)) {
    const [left, right] = [bin, bin + 1].map((i) => edges[i] + ((floors[i] - edges[i]) * y) / height);
    assert.ok(x > left + 0.9 * radius && x < right - 0.9 * radius, `${x} of bin ${bin}`);
    assert.ok(y > 0 && y < height - 0.9 * radius);
  }
});

test("the same landings make the same pile, to the last bit", () => {
  const [one, two] = [filled(COUNTS), filled(COUNTS)];
  assert.equal(settle(one), settle(two));
  assert.deepEqual(discsIn(one), discsIn(two));
});

test("a disc enters at its ball's speed, and wakes others", () => {
  const heap = new Heap(machine, PLAN);
  heap.add(4, { x: 0.02, speed: 3 });
  heap.step();
  const [{ x, y }] = discsIn(heap);
  assert.equal(x, 0.02);
  const fallen = y - PLAN.entry;
  assert.ok(Math.abs(fallen - 3 * STEP - 0.5 * PLAN.gravity * STEP ** 2) < 0.2 * PLAN.gravity * STEP ** 2, `${fallen}`);
  settle(heap);
  const [lay] = discsIn(heap);
  heap.add(4, { x: 0.02 + 0.3 * PLAN.radius, speed: 3 });
  assert.ok(heap.runs);
  settle(heap);
  const [pushed] = discsIn(heap);
  assert.ok(pushed.x < lay.x, "it was pushed to the side");
});

test("a full column is reported, and the pile stops", () => {
  const heap = filled([0, 0, 0, 0, 300, 0, 0, 0, 0]);
  settle(heap);
  assert.ok(heap.full);
  assert.ok(discsIn(heap).length < 300);
});

function pileOf(counts) {
  const pile = new Pile({ heapFor: (plan) => new Heap(machine, plan), stepMs: 1000 * STEP }, null);
  pile.lay(BOARD, GEOMETRY, HEIGHT, counts);
  return pile;
}

/** @param {Pile} pile @returns {number} frames with a new picture, until nothing moved */
function watch(pile, still) {
  let [shown, now] = [0, 1000];
  for (; pile.runs && now < 1000 + 1000 * STEP * MOST_STEPS; now += 1000 * STEP) shown += pile.advance(now, still) ? 1 : 0;
  assert.equal(pile.runs, false);
  assert.equal(pile.advance(now, still), false, "at rest the picture does not change");
  return shown;
}

test("the pile falls, or with reduced motion appears at rest", () => {
  assert.ok(watch(pileOf(COUNTS), false) > 30);
  assert.equal(watch(pileOf(COUNTS), true), 1);
});

test("in a resized tray the same discs appear at rest", () => {
  const pile = pileOf(COUNTS);
  watch(pile, false);
  pile.lay(BOARD, { ...layOut(BOARD, 360), spread: 1 }, 27, COUNTS);
  assert.equal(watch(pile, false), 1);
});

test("if a column is full, discs represent more balls", () => {
  const counts = [...COUNTS];
  const pile = pileOf(counts);
  assert.equal(pile.share, 1);
  watch(pile, true);
  while (pile.share === 1) {
    counts[4] += 1;
    assert.ok(counts[4] < 1000);
    pile.update(counts, { x: 0, speed: 2 });
  }
  assert.equal(pile.share, 2);
  assert.equal(counts[4], PLAN.room[4] + 1);
  watch(pile, true);
  pile.update(counts.map(() => 0), null);
  assert.equal(pile.share, 1, "another table's counts begin again");
  assert.equal(pile.runs, false);
});

test("ten million balls also make a pile", () => {
  const pile = pileOf(COUNTS.map((count) => 1_000_000 * count));
  assert.ok(pile.share >= 100_000);
  assert.equal(watch(pile, true), 1);
});
