// Axes: places and labels of their ticks. Pure.

import { number } from "../texts/text.js";

/**
 * Round values that divide [from, to] into about `count` parts.
 * @param {number} from
 * @param {number} to
 * @param {number} count
 * @returns {number[]}
 */
export function ticks(from, to, count) {
  const span = to - from;
  if (!(span > 0)) return [from];
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((nice) => nice * power >= rough) ?? 10);
  const found = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + 1e-9 * step; i += 1) {
    found.push(Number((i * step).toPrecision(12)));
  }
  return found;
}

/**
 * Powers of ten from `from` to `to`, at most about `count` of them.
 * @param {number} from
 * @param {number} to
 * @param {number} count
 * @returns {number[]}
 */
export function powerTicks(from, to, count) {
  const low = Math.ceil(Math.log10(from) - 1e-9);
  const high = Math.floor(Math.log10(to) + 1e-9);
  const step = Math.max(1, Math.ceil((high - low + 1) / count));
  const found = [];
  for (let power = high; power >= low; power -= step) found.unshift(power);
  return found.map((power) => 10 ** power);
}

/** @type {Record<string, string>} */
const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** @param {number} value a power of ten @returns {string} "10⁻⁶", "1", "10" */
export function powerText(value) {
  const power = Math.round(Math.log10(value));
  if (power >= 0 && power <= 2) return String(10 ** power);
  return `10${[...String(power)].map((letter) => SUPERSCRIPTS[letter]).join("")}`;
}

/** @param {number} value @returns {string} at most 4 digits; very large and very small values with a power of ten */
export function figure(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [digits, power] = value.toExponential(2).split("e");
    const raised = [...String(Number(power))].map((letter) => SUPERSCRIPTS[letter]).join("");
    const shown = number(Number(digits), { minimumFractionDigits: 2 });
    return `${shown.replace("-", "−")}·10${raised}`;
  }
  return number(value, { maximumSignificantDigits: 4, useGrouping: false }).replace("-", "−");
}

/** @type {[number, string][]} */
const PREFIXES = [[1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"]];

/**
 * The prefix under which values up to `most` are easy to read.
 * @param {number} most in the plain unit
 * @param {string} unit "J"
 * @returns {{unit: string, per: number}} per: factor from the plain unit to this one
 */
export function prefixed(most, unit) {
  const fitting = PREFIXES.find(([size]) => most >= size) ?? PREFIXES[PREFIXES.length - 1];
  const [size, prefix] = most > 0 ? fitting : [1, ""];
  return { unit: `${prefix}${unit}`, per: 1 / size };
}
