// What a sample of landed balls says, and what theory says of it. Pure.

/** @typedef {{n: number, mean: number, sd: number, se: number}} Summary se: standard error of the mean */

/** @param {number[]} counts of the balls in bins 0, 1, … @returns {Summary} NaN where too few balls landed */
export function summaryOf(counts) {
  const n = counts.reduce((total, count) => total + count, 0);
  const mean = counts.reduce((total, count, bin) => total + count * bin, 0) / n;
  const square = counts.reduce((total, count, bin) => total + count * (bin - mean) ** 2, 0);
  const sd = n > 1 ? Math.sqrt(square / (n - 1)) : Number.NaN;
  return { n, mean, sd, se: sd / Math.sqrt(n) };
}

/** @param {number} rows @param {number} p @param {number} n balls @returns {Summary} of the binomial law */
export function theoryOf(rows, p, n) {
  const sd = Math.sqrt(rows * p * (1 - p));
  return { n, mean: rows * p, sd, se: sd / Math.sqrt(n) };
}

/** @param {number} x @param {Pick<Summary, "mean" | "sd">} law @returns {number} the density of the normal law */
export function normalDensity(x, { mean, sd }) {
  return Math.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * Math.sqrt(2 * Math.PI));
}

/**
 * The average of the first n values, for n = 1, 2, … until it has many points; then n grows by a factor.
 * @param {number[]} values @param {number} [factor]
 * @returns {{x: number, y: number}[]} x: n
 */
export function averages(values, factor = 1.02) {
  const points = [];
  let [total, next] = [0, 1];
  for (let n = 1; n <= values.length; n += 1) {
    total += values[n - 1];
    if (n < next && n < values.length) continue;
    points.push({ x: n, y: total / n });
    next = Math.max(n + 1, n * factor);
  }
  return points;
}

/** @param {number[]} values @param {number} size @returns {number[]} the means of consecutive whole samples */
export function sampleMeans(values, size) {
  return Array.from({ length: Math.floor(values.length / size) }, (_, i) =>
    values.slice(i * size, (i + 1) * size).reduce((sum, value) => sum + value, 0) / size);
}

/**
 * @param {number[]} values @param {number} from @param {number} width of a class
 * @param {number} classes @returns {number[]} how many values are in each
 */
export function countsOf(values, from, width, classes) {
  const counts = new Array(classes).fill(0);
  for (const value of values) {
    const place = Math.floor((value - from) / width + 1e-9);
    if (place >= 0 && place < classes) counts[place] += 1;
  }
  return counts;
}

/** @param {number[]} one @param {number[]} two @returns {number} the share that both have in common, 0 … 1 */
export function overlap(one, two) {
  const [a, b] = [one, two].map((counts) => counts.reduce((total, count) => total + count, 0));
  return a && b ? one.reduce((sum, count, bin) => sum + Math.min(count / a, two[bin] / b), 0) : 0;
}
