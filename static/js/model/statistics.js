// Goodness-of-fit tests, and confidence intervals of means. Pure.
//
// Special functions follow Abramowitz and Stegun, chapters 6 and 26: series where they converge
// fast, elsewhere continued fractions by Lentz's method. Relative errors are below 1e-10.

/** @import { Mean } from "./mean.js" */

const TINY = 1e-300; // keeps Lentz's quotients from dividing by zero
const CLOSE = 1e-15; // relative change below which a series or a fraction has converged
const MOST_TERMS = 10_000;
const FEWEST = 5; // expected in a group; with fewer, the chi-square law is a poor approximation

// Lanczos' approximation with g = 7 and nine terms.
const LANCZOS = [
  0.99999999999980993, 676.5203681218851, -1259.1392167224028, 771.32342877765313,
  -176.61502916214059, 12.507343278686905, -0.13857109526572012, 9.9843695780195716e-6,
  1.5056327351493116e-7,
];

/** @param {number} x > 0 @returns {number} logarithm of the gamma function */
export function logGamma(x) {
  let sum = LANCZOS[0];
  for (let i = 1; i < LANCZOS.length; i += 1) sum += LANCZOS[i] / (x - 1 + i);
  const t = x + 6.5;
  return 0.5 * Math.log(2 * Math.PI) + (x - 0.5) * Math.log(t) - t + Math.log(sum);
}

/**
 * The upper regularised incomplete gamma function Q(a, x).
 * @param {number} a > 0
 * @param {number} x >= 0
 * @returns {number} 0 … 1
 */
export function gammaQ(a, x) {
  if (x <= 0) return 1;
  const scale = Math.exp(a * Math.log(x) - x - logGamma(a));
  if (x < a + 1) {
    let term = 1 / a;
    let sum = term;
    for (let n = 1; n < MOST_TERMS && term > sum * CLOSE; n += 1) {
      term *= x / (a + n);
      sum += term;
    }
    return Math.max(0, 1 - scale * sum);
  }
  return scale * fraction((n) => (n === 0 ? 1 : n * (a - n)), (n) => x + 2 * n + 1 - a);
}

/** @param {number} statistic @param {number} freedom @returns {number} the probability of a larger statistic */
export function chiSquareTail(statistic, freedom) {
  return gammaQ(freedom / 2, statistic / 2);
}

/**
 * The regularised incomplete beta function I_x(a, b).
 * @param {number} x 0 … 1
 * @param {number} a > 0
 * @param {number} b > 0
 * @returns {number} 0 … 1
 */
function betaI(x, a, b) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  // The fraction converges fast on one side of the mean; the other is its mirror image.
  if (x > (a + 1) / (a + b + 2)) return 1 - betaI(1 - x, b, a);
  const log = a * Math.log(x) + b * Math.log1p(-x) + logGamma(a + b) - logGamma(a) - logGamma(b);
  /** @param {number} n */
  const numerator = (n) => {
    if (n === 0) return 1;
    const m = Math.floor(n / 2);
    if (n % 2 === 0) return (m * (b - m) * x) / ((a + n - 1) * (a + n));
    return (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1));
  };
  return (Math.exp(log) / a) * fraction(numerator, () => 1);
}

/**
 * The continued fraction a0 / (b0 + a1 / (b1 + …)), by Lentz's method.
 * @param {(n: number) => number} numerator
 * @param {(n: number) => number} denominator
 */
function fraction(numerator, denominator) {
  let value = TINY;
  let c = value;
  let d = 0;
  for (let n = 0; n < MOST_TERMS; n += 1) {
    const a = numerator(n);
    const b = denominator(n);
    d = b + a * d;
    d = 1 / (d === 0 ? TINY : d);
    c = b + a / c;
    c = c === 0 ? TINY : c;
    const change = c * d;
    value *= change;
    if (Math.abs(change - 1) < CLOSE) break;
  }
  return value;
}

/**
 * The bound that |t| stays below with this probability, if t follows Student's law.
 * @param {number} confidence 0 … 1
 * @param {number} freedom >= 1
 */
export function studentBound(confidence, freedom) {
  /** @param {number} t */
  const outside = (t) => betaI(freedom / (freedom + t * t), freedom / 2, 0.5);
  let low = 0;
  let high = 2;
  while (outside(high) > 1 - confidence) high *= 2;
  for (let i = 0; i < 80; i += 1) {
    const middle = (low + high) / 2;
    if (outside(middle) > 1 - confidence) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

/**
 * @typedef {object} Fit
 * @property {number} statistic G, which follows the chi-square law if the chances are right
 * @property {number} freedom
 * @property {number} p the probability of a G at least as large, if the chances are right
 * @property {number} groups bins, after rare ones were merged with their neighbours
 */

/**
 * G-test of counts against chances.
 * @param {number[]} counts
 * @param {number[]} chances with the sum 1
 * @returns {Fit | null} null while the counts are too small for a test
 */
export function fitTest(counts, chances) {
  const total = sum(counts);
  const groups = grouped(chances.map((chance) => chance * total));
  const seen = groups.map((bins) => sumOver(counts, bins));
  const due = groups.map((bins) => total * sumOver(chances, bins));
  if (groups.length < 2) return null;
  return judged(2 * sum(seen.map((count, i) => surprise(count, due[i]))), groups.length);
}

/**
 * G-test of whether two samples come from the same distribution.
 * @param {number[]} one
 * @param {number[]} two
 * @returns {Fit | null}
 */
export function sameTest(one, two) {
  const totals = [sum(one), sum(two)];
  const both = totals[0] + totals[1];
  if (totals[0] === 0 || totals[1] === 0) return null;
  const smaller = Math.min(...totals) / both;
  const groups = grouped(one.map((count, bin) => (count + two[bin]) * smaller));
  if (groups.length < 2) return null;
  let g = 0;
  for (const bins of groups) {
    const counts = [sumOver(one, bins), sumOver(two, bins)];
    const here = counts[0] + counts[1];
    counts.forEach((count, i) => {
      g += 2 * surprise(count, (here * totals[i]) / both);
    });
  }
  return judged(g, groups.length);
}

/** @param {number} trials @param {number} p of a success @returns {number[]} chances of 0, 1, … successes */
export function binomialChances(trials, p) {
  const chances = [(1 - p) ** trials];
  for (let k = 1; k <= trials; k += 1) chances.push((chances[k - 1] * (trials - k + 1) * p) / (k * (1 - p)));
  return chances;
}

/** @param {number} statistic @param {number} groups */
function judged(statistic, groups) {
  const freedom = groups - 1;
  return { statistic, freedom, p: chiSquareTail(statistic, freedom), groups };
}

/**
 * Merges neighbouring bins, from the left, until each group expects at least FEWEST.
 * @param {number[]} expected
 */
function grouped(expected) {
  /** @type {number[][]} */
  const groups = [];
  /** @type {number[]} */
  let open = [];
  expected.forEach((_, bin) => {
    open.push(bin);
    if (sumOver(expected, open) < FEWEST) return;
    groups.push(open);
    open = [];
  });
  // The bins left at the right end expect too little for a group: they join the last one.
  if (open.length && groups.length) groups[groups.length - 1].push(...open);
  return groups;
}

/** @param {number} count @param {number} due */
function surprise(count, due) {
  return count === 0 ? 0 : count * Math.log(count / due);
}

/** @param {number[]} values */
function sum(values) {
  return values.reduce((total, value) => total + value, 0);
}

/** @param {number[]} values @param {number[]} places */
function sumOver(values, places) {
  return places.reduce((total, place) => total + values[place], 0);
}

/**
 * @param {Mean} mean @param {number} confidence
 * @returns {number} half the width of the mean's interval; infinite for fewer than two values
 */
export function doubtOf({ count, square }, confidence) {
  if (count < 2) return Number.POSITIVE_INFINITY;
  return studentBound(confidence, count - 1) * Math.sqrt(square / (count - 1) / count);
}
