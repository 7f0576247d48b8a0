// Statistics compared with known values, and tests whose false alarms are as frequent as they state.

import assert from "node:assert/strict";
import { test } from "node:test";

import { Mean } from "../../../static/js/model/mean.js";
import {
  chiSquareTail, doubtOf, fitTest, gammaQ, logGamma, sameTest, studentBound,
} from "../../../static/js/model/statistics.js";
import { chance, choose, near, nearly } from "../support.js";

// Chi-square: statistic, degrees of freedom, upper tail. To 12 digits by arbitrary-precision
// arithmetic; those at 0.05 are in every table.
for (const [statistic, freedom, tail] of [
  [3.841458820694124, 1, 0.05],
  [18.307038053275146, 10, 0.05],
  [26.296227604864235, 16, 0.05],
  [0.5, 1, 0.479500122186953],
  [2, 2, Math.exp(-1)],
  [40, 2, Math.exp(-20)],
  [1, 16, 0.999999937803091],
]) {
  test(`the chi-square tail of ${statistic} with ${freedom} is right`, () => {
    nearly(chiSquareTail(statistic, freedom), tail, 1e-9);
  });
}

for (const half of [1, 4, 40]) {
  test(`the incomplete gamma of ${half} is a Poisson sum`, () => {
    for (const x of [0.1, 1, half, 2 * half, 5 * half]) {
      let term = Math.exp(-x);
      let poisson = 0;
      for (let k = 0; k < half; k += 1) {
        poisson += term;
        term *= x / (k + 1);
      }
      nearly(gammaQ(half, x), poisson, 1e-9, `${x}`);
    }
  });
}

// Student's t: degrees of freedom, bound at 95 %.
for (const [freedom, bound] of [
  [1, 12.706204736], [2, 4.302652730], [10, 2.228138852], [1000, 1.962339081],
]) {
  test(`Student's bound with ${freedom} is that of the tables`, () => {
    nearly(studentBound(0.95, freedom), bound, 1e-8);
  });
}

test("the gamma function is the factorial", () => {
  near(logGamma(0.5), Math.log(Math.PI) / 2, 1e-12);
  near(logGamma(3.5), Math.log((15 * Math.sqrt(Math.PI)) / 8), 1e-12);
  let logFactorial = 0;
  for (let n = 1; n <= 170; n += 1) {
    near(logGamma(n), logFactorial, 1e-12 + 1e-12 * logFactorial, `${n}`);
    logFactorial += Math.log(n);
  }
  // By Stirling's series, whose next term is below 1e-17 here.
  const x = 1e5;
  const stirling = (x - 0.5) * Math.log(x) - x + 0.5 * Math.log(2 * Math.PI) + 1 / (12 * x);
  nearly(logGamma(x), stirling, 1e-12);
});

test("a fit of three bins is that computed by hand", () => {
  const counts = [30, 20, 10];
  const fit = fitTest(counts, [1 / 3, 1 / 3, 1 / 3]);
  const g = 2 * counts.reduce((sum, count) => sum + count * Math.log(count / 20), 0);
  nearly(fit.statistic, g, 1e-9);
  assert.equal(fit.freedom, 2);
  nearly(fit.p, Math.exp(-g / 2), 1e-9);
});

test("rare bins are merged, and too few balls are not tested", () => {
  const chances = choose(8).map((ways) => ways / 256);
  assert.equal(fitTest(Array(9).fill(0), chances), null);
  assert.equal(fitTest([0, 0, 0, 1, 2, 1, 0, 0, 0], chances), null);
  const { groups } = fitTest([0, 1, 4, 8, 10, 9, 5, 2, 1], chances);
  assert.ok(groups >= 3 && groups < 9, `${groups}`);
  assert.equal(fitTest([40, 310, 1090, 2190, 2730, 2190, 1100, 310, 40], chances).groups, 9);
});

test("false alarms are as frequent as p says", () => {
  const random = chance(7);
  const share = choose(16).map((ways) => ways / 2 ** 16);
  const sample = (balls) => {
    const counts = Array(17).fill(0);
    for (let i = 0; i < balls; i += 1) {
      let [bits, bin] = [Math.floor(random() * 2 ** 16), 0];
      for (; bits; bits &= bits - 1) bin += 1;
      counts[bin] += 1;
    }
    return counts;
  };
  const samples = Array.from({ length: 1500 }, () => sample(400));
  const alone = samples.map((counts) => fitTest(counts, share).p);
  const both = samples.map((counts) => sameTest(counts, sample(2000)).p);
  for (const found of [alone, both]) {
    const below = (p) => found.filter((one) => one < p).length / found.length;
    assert.ok(below(0.05) > 0.03 && below(0.05) < 0.075, `${below(0.05)}`);
    assert.ok(below(0.5) > 0.44 && below(0.5) < 0.56, `${below(0.5)}`);
  }
});

test("wrong chances are found", () => {
  const share = choose(8).map((ways) => ways / 256);
  const skewed = [...share.slice(1), share[0]].map((part) => Math.round(1000 * part));
  assert.ok(fitTest(skewed, share).p < 1e-6);
});

test("mean and interval are those of the textbook", () => {
  const values = [0.2, 0.2, 1, 4, 0.3];
  const one = new Mean();
  for (const value of values) one.add(value);
  const many = new Mean();
  many.add(0.2, 2);
  for (const value of values.slice(2)) many.add(value);
  const mean = values.reduce((sum, value) => sum + value, 0) / 5;
  const spread = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / 4);
  for (const found of [one, many]) {
    nearly(found.mean, mean, 1e-9);
    nearly(doubtOf(found, 0.95), (2.7764451052 * spread) / Math.sqrt(5), 1e-6);
  }
});
