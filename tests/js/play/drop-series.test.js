// Balls that are reported together: the sums count each of them once, and say why an auto-drop ended.

import assert from "node:assert/strict";
import { test } from "node:test";

import { DropSeries } from "../../../static/js/play/drop-series.js";
import { chance, near } from "../support.js";

const NEVER = Number.POSITIVE_INFINITY;
const KEEP = { how: "keep", factor: 1 };
const NO_LIMITS = { win: NEVER, loss: NEVER, onWin: KEEP, onLoss: KEEP };
const FULL = () => false;
const FREE = () => true;

/** A series whose table accepts every ball, with a stake of 1. */
function running(limits = null, practice = false) {
  const series = new DropSeries({ practice, limits: limits && { ...NO_LIMITS, ...limits } });
  const stakes = [];
  const dropper = {
    stake: () => series.factor,
    drop: (stake) => ({ ref: `d${stakes.push(stake) - 1}`, stake }),
  };
  const land = (ref, paid, more = {}) =>
    series.land({ ref, stake: stakes[Number(ref.slice(1))], paid, score: paid, bin: 1, ...more });
  const pass = (from, to, room = FREE) => { for (let now = from; now < to; now += 5) series.give(now, room); };
  return { series, dropper, stakes, land, pass };
}

test("a pause is not followed by a burst", () => {
  const { series, dropper, pass } = running();
  series.add(100, dropper, 0, 10);
  const given = [[0, 1000], [60_000, 60_100], [60_100, 61_100]].map(([from, to]) => {
    const before = series.falling;
    pass(from, to);
    return series.falling - before;
  });
  assert.equal(given[0], 10);
  assert.ok(given[1] <= 2);
  near(given[2], 10, 1);
  assert.equal(series.left, 100 - given[0] - given[1] - given[2]);
});

test("four presses of 20 balls drop 80, one after another at one rate", () => {
  const { series, dropper, pass } = running();
  for (let press = 0; press < 4; press += 1) series.add(20, dropper, 0);
  assert.equal(series.left, 80);
  pass(0, 1000);
  near(series.falling, 12, 1);
  pass(1000, 8000);
  assert.deepEqual([series.falling, series.left], [80, 0]);
});

test("a loss limit counts the stakes in flight as lost, so that it is never exceeded", () => {
  const { series, dropper, land, pass } = running({ loss: 5 });
  series.add(NEVER, dropper, 0, 16);
  pass(0, 10_000);
  assert.deepEqual([series.falling, series.stopped], [5, null], "it waits: these balls may win");
  land("d0", 3);
  pass(10_000, 12_000);
  assert.equal(series.falling, 7);
  for (let ball = 1; ball < 8; ball += 1) land(`d${ball}`, 0);
  pass(12_000, 12_500);
  assert.deepEqual([series.stopped, series.over, series.profit], ["loss", true, -5]);
  assert.equal(series.words().text, "Stopped at your loss limit: 8 balls, −5.00");
});

test("no auto-drop loses more than its limit, and none that stops for its profit has less", () => {
  for (let seed = 0; seed < 200; seed += 1) {
    const random = chance(seed);
    const { series, dropper, land, pass, stakes } = running({
      loss: 1 + Math.floor(8 * random()), win: 1 + Math.floor(8 * random()),
      onLoss: seed % 3 ? KEEP : { how: "times", factor: 1.5 }, onWin: { how: seed % 2 ? "reset" : "keep", factor: 1 },
    });
    series.add(200, dropper, 0, 16);
    const open = [];
    for (let now = 0; !series.over; now += 100) {
      const before = stakes.length;
      pass(now, now + 100);
      for (let ball = before; ball < stakes.length; ball += 1) open.push(ball);
      if (open.length && random() < 0.7) {
        const [ball] = open.splice(Math.floor(random() * open.length), 1);
        land(`d${ball}`, stakes[ball] * [0, 0.3, 0.5, 1, 2, 4][Math.floor(6 * random())]);
      }
    }
    assert.ok(series.profit >= -series.limits.loss, `${seed}: ${series.profit} at a limit of ${series.limits.loss}`);
    if (series.stopped === "win") assert.ok(series.profit >= series.limits.win);
    assert.ok(["win", "loss", "finished"].includes(series.stopped));
  }
});

test("a profit ends it once the balls in flight have landed", () => {
  const { series, dropper, land, pass } = running({ win: 3 });
  series.add(NEVER, dropper, 0, 1000);
  pass(0, 11);
  land("d0", 1);
  land("d1", 5);
  const { falling } = series;
  pass(30, 60);
  assert.deepEqual([series.falling, series.stopped], [falling, null], "it waits for the others");
  for (let ball = 2; series.falling > 0; ball += 1) land(`d${ball}`, 1);
  pass(60, 62);
  assert.equal(series.stopped, "win");
  assert.match(series.words().text, /^Stopped at your profit limit: \d+ balls, \+4\.00$/);
});

test("after a win or a loss the stake changes, and the next ball waits for it", () => {
  const { series, dropper, land, pass, stakes } = running({ onLoss: { how: "times", factor: 2 }, onWin: { how: "reset", factor: 1 } });
  series.add(5, dropper, 0, 16);
  for (const [ball, paid] of [[0, 0.5], [1, 0], [2, 4], [3, 20], [4, 1]]) {
    pass(1000 * ball, 1000 * ball + 900);
    assert.equal(series.falling, 1);
    land(`d${ball}`, paid);
  }
  assert.deepEqual(stakes, [1, 2, 4, 4, 1], "a ball that pays its stake changes nothing");
  pass(5000, 5100);
  assert.equal(series.stopped, "finished");
});

test("an auto-drop whose balls were refused says that it was cut short", () => {
  const { series, dropper, land, pass } = running({});
  series.add(6, dropper, 0, 1000);
  pass(0, 40);
  assert.equal(series.stopped, "finished");
  assert.ok(series.refuse("d4"));
  assert.ok(series.refuse("d5"));
  for (const ref of ["d0", "d1", "d2", "d3"]) land(ref, 1.5);
  assert.equal(series.words().text, "Auto was cut short: 4 of 6 balls, +2.00");
  const whole = running({});
  whole.series.add(1, whole.dropper, 0);
  whole.pass(0, 5);
  whole.land("d0", 1);
  assert.equal(whole.series.words().text, "Auto finished: 1 ball, 0.00");
});

test("an auto-drop of practice has no profit", () => {
  const { series, dropper, land, pass } = running({}, true);
  series.add(2, dropper, 0, 1000);
  pass(0, 11);
  for (const ref of ["d0", "d1"]) land(ref, 9, { practice: true });
  assert.equal(series.words().text, "Auto finished: 2 balls, practice");
});

test("one ball and several balls are reported in the same way", () => {
  const one = running();
  one.series.add(1, one.dropper, 0);
  one.pass(0, 5);
  one.land("d0", 1.4);
  assert.deepEqual(one.series.words(), { text: "1.4x: staked 1.00, won 1.40 (+0.40)", score: 1.4 });
  const some = running();
  some.series.add(2, some.dropper, 0);
  some.pass(0, 1000);
  some.land("d0", 0.5);
  some.land("d1", 2.7);
  assert.deepEqual(some.series.words(), { text: "2 balls: staked 2.00, won 3.20 (+1.20)", score: 1.6 });
  const practice = running(null, true);
  practice.series.add(1, practice.dropper, 0);
  practice.pass(0, 5);
  practice.land("d0", 9, { practice: true });
  assert.equal(practice.series.words().text, "9x (practice)");
  const many = running(null, true);
  many.series.add(2, many.dropper, 0);
  many.pass(0, 1000);
  many.land("d0", 9, { practice: true });
  many.land("d1", 1, { practice: true });
  assert.deepEqual(many.series.words(), { text: "2 practice balls: 5.00x on average", score: 5 });
});

test("a refused ball does not count, and a full table delays it", () => {
  const { series, dropper, pass } = running();
  series.add(1, dropper, 0);
  assert.ok(series.give(0, FULL) > 0);
  assert.equal(series.left, 1);
  pass(1000, 1005);
  assert.equal(series.refuse("d0"), true);
  assert.deepEqual([series.over, series.words()], [true, null]);
});

test("balls in flight before a reload are reported like others", () => {
  const { series, land, stakes } = running();
  stakes.push(2);
  series.adopt({ ref: "d0", stake: 2 });
  assert.deepEqual([series.falling, series.over], [1, false]);
  land("d0", 3);
  assert.equal(series.words().text, "3x: staked 2.00, won 3.00 (+1.00)");
});
