// Helpers for tests: golden files, comparisons, seeded random numbers, a board, storage.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

const ROOT = new URL("../../", import.meta.url);

/** @param {string} path below the repository's root */
export function json(path) {
  return JSON.parse(readFileSync(new URL(path, ROOT), "utf8"));
}

/** @param {string} hex */
export function bytesOf(hex) {
  return Uint8Array.from(hex.match(/../g) ?? [], (pair) => parseInt(pair, 16)).buffer;
}

/** Asserts that two numbers differ by at most a tolerance; NaN always fails. */
export function near(actual, expected, tolerance, message = "") {
  const off = Math.abs(actual - expected);
  assert.ok(off <= tolerance, `${message} ${actual} is not within ${tolerance} of ${expected}`);
}

/** The same, with the tolerance as a fraction of the expected value. */
export function nearly(actual, expected, share, message) {
  near(actual, expected, share * Math.abs(expected), message);
}

/** Seeded random numbers, by mulberry32. @returns {() => number} 0 … 1 */
export function chance(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** @returns {number[]} a row of Pascal's triangle */
export function choose(rows) {
  let row = [1];
  for (let i = 0; i < rows; i += 1) row = [...row, 0].map((value, k) => value + (row[k - 1] ?? 0));
  return row;
}

/** A board like the preset triangle-8: eight rows of pegs between two walls, over nine bins. */
export function triangle() {
  const [gap, top] = [0.5, 0.6];
  const pegs = [];
  for (let row = 0; row < 8; row += 1) {
    for (let i = 0; i < row + 3; i += 1) {
      pegs.push({ x: gap * (i - (row + 2) / 2), y: top + 0.45 * row, radius: 0.06 });
    }
  }
  const edges = Array.from({ length: 10 }, (_, i) => gap * (i - 4.5));
  return {
    name: "triangle", width: 6, height: 5, gravity: 9.81, drag: 0.5,
    ball: { radius: 0.08, density: 1, restitution: 0.6, friction: 0.1 },
    pegs, peg_material: { restitution: 0.6, friction: 0.1 },
    walls: [
      { x1: -0.9, y1: -0.2, x2: -2.6, y2: 4.5 },
      { x1: 0.9, y1: -0.2, x2: 2.6, y2: 4.5 },
    ],
    wall_material: { restitution: 0.6, friction: 0.1 },
    bins: { y: 4.5, edges, multipliers: [10, 3, 1.5, 1, 0.5, 1, 1.5, 3, 10] },
    drop: { x: 0, y: 0, jitter: 0.3 },
  };
}

/** A fake of a browser's storage. @returns {Pick<Storage, "getItem" | "setItem" | "removeItem">} */
export function storage() {
  const kept = new Map();
  return {
    getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, value),
    removeItem: (key) => kept.delete(key),
  };
}
