// How far apart two drops are, and when they part. Pure.

/** @import { Motion } from "../model/motion/drop.js" */

const SAMPLES = 240; // a second; the parting is then found by halving

/** Smallest distance shown, m: the square of a rounding error of metres. */
export const FLOOR = 1e-18;

/**
 * @param {Motion} one
 * @param {Motion} two
 * @param {number} t seconds
 * @returns {number} metres between the centres
 */
export function distanceAt(one, two, t) {
  const a = one.stateAt(t);
  const b = two.stateAt(t);
  return Math.hypot(a.x - b.x, a.y - b.y);
}

/**
 * @param {Motion} one
 * @param {Motion} two
 * @returns {number} seconds for which both balls are on the board
 */
export function together(one, two) {
  return Math.min(one.duration, two.duration);
}

/**
 * The distance against time, both balls' events included.
 * @param {Motion} one
 * @param {Motion} two
 * @returns {{t: number, distance: number}[]}
 */
export function distances(one, two) {
  const end = together(one, two);
  const count = Math.ceil(end * SAMPLES);
  const times = Array.from({ length: count }, (_, i) => i / SAMPLES);
  for (const { t } of [...one.events, ...two.events]) if (t < end) times.push(t);
  times.push(end);
  times.sort((a, b) => a - b);
  return times.map((t) => ({ t, distance: distanceAt(one, two, t) }));
}

/**
 * The distance when the first ball makes its nth hit; the 0th is the start.
 * @param {Motion} one
 * @param {Motion} two
 * @returns {{hit: number, distance: number}[]}
 */
export function distancesAtHits(one, two) {
  const end = together(one, two);
  const rows = [{ hit: 0, distance: distanceAt(one, two, 0) }];
  one.hits.forEach(({ t }, i) => {
    if (t <= end) rows.push({ hit: i + 1, distance: distanceAt(one, two, t) });
  });
  return rows;
}

/**
 * When the balls first are further apart than a limit.
 * @param {number} limit metres
 * @param {Motion} one
 * @param {Motion} two
 * @returns {{t: number, hits: number} | null} hits: how often the first ball had hit by then
 */
export function parting(one, two, limit) {
  const rows = distances(one, two);
  const found = rows.findIndex(({ distance }) => distance > limit);
  if (found < 0) return null;
  let early = found ? rows[found - 1].t : 0;
  let late = rows[found].t;
  for (let i = 0; i < 50; i += 1) {
    const middle = (early + late) / 2;
    if (distanceAt(one, two, middle) > limit) late = middle;
    else early = middle;
  }
  return { t: late, hits: one.hits.filter(({ t }) => t <= late).length };
}

/**
 * By how much each hit multiplied the distance until they parted: the geometric mean.
 * @param {Motion} one
 * @param {Motion} two
 * @param {number} limit
 * @returns {number | null} null without a hit, or when they started more than a limit apart
 */
export function growthPerHit(one, two, limit) {
  const parted = parting(one, two, limit);
  const start = distanceAt(one, two, 0);
  if (!parted || parted.hits === 0 || start === 0 || start >= limit) return null;
  return (limit / start) ** (1 / parted.hits);
}
