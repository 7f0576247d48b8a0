// The numbers of a lesson, against values computed by hand or by the law itself.

import assert from "node:assert/strict";
import { test } from "node:test";

import {
  averages, countsOf, normalDensity, overlap, sampleMeans, summaryOf, theoryOf,
} from "../../../static/js/class/statistics.js";
import { binomialChances } from "../../../static/js/model/statistics.js";

const near = (value, due, error = 1e-12) => assert.ok(Math.abs(value - due) <= error, `${value}, not ${due}`);

test("a summary is that of the single values", () => {
  const { n, mean, sd, se } = summaryOf([1, 0, 2, 1]); // 0, 2, 2, 3
  assert.equal(n, 4);
  near(mean, 1.75);
  near(sd, Math.sqrt(4.75 / 3));
  near(se, sd / 2);
  assert.ok(Number.isNaN(summaryOf([0, 1]).sd), "one ball has no deviation");
  assert.ok(Number.isNaN(summaryOf([0, 0]).mean));
});

test("theory has the moments of the binomial chances", () => {
  for (const [rows, p] of [[5, 0.2], [12, 0.5], [30, 0.8]]) {
    const chances = binomialChances(rows, p);
    const law = theoryOf(rows, p, 100);
    near(chances.reduce((sum, chance) => sum + chance, 0), 1);
    near(chances.reduce((sum, chance, k) => sum + k * chance, 0), law.mean, 1e-9);
    near(chances.reduce((sum, chance, k) => sum + (k - law.mean) ** 2 * chance, 0), law.sd ** 2, 1e-9);
    near(law.se, law.sd / 10);
  }
  assert.deepEqual(binomialChances(2, 0.5), [0.25, 0.5, 0.25]);
});

test("the normal curve covers the area 1", () => {
  const law = theoryOf(20, 0.3, 1);
  const area = Array.from({ length: 4000 }, (_, i) => -20 + i / 50).reduce((sum, x) => sum + normalDensity(x, law) / 50, 0);
  near(area, 1, 1e-6);
});

test("the average over n keeps its first values and its last", () => {
  assert.deepEqual(averages([2, 4, 9]), [{ x: 1, y: 2 }, { x: 2, y: 3 }, { x: 3, y: 5 }]);
  const many = averages(Array.from({ length: 10_000 }, (_, i) => i % 2));
  assert.ok(many.length < 500);
  assert.deepEqual(many.at(-1), { x: 10_000, y: 0.5 });
});

test("only whole samples have a mean, and each falls into one class", () => {
  assert.deepEqual(sampleMeans([1, 3, 5, 7, 9], 2), [2, 6]);
  assert.deepEqual(countsOf([0.1, 0.2, 0.3, 0.9], 0.05, 0.1, 3), [1, 1, 1]);
});

test("a guess of the same shape has everything in common, whatever its size", () => {
  assert.equal(overlap([1, 2, 1], [50, 100, 50]), 1);
  assert.equal(overlap([1, 0], [0, 1]), 0);
  near(overlap([1, 1], [3, 1]), 0.75);
  assert.equal(overlap([0, 0], [1, 1]), 0);
});
