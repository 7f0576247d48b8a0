// A certificate (what the server has proven about a drop) in words, and where two proven paths part. Pure.

import { t } from "../texts/text.js";

/** @import { Key } from "../texts/text.js" */

/**
 * @typedef {{low: number, high: number, text: string}} Enclosed
 * @typedef {[kind: number, index: number, t: number, x: number, y: number, error: number]} ProvenEvent
 */

/**
 * @typedef {object} Certificate of a drop, as REST returns it
 * @property {boolean} certified
 * @property {number | null} bin
 * @property {string | null} unsettled
 * @property {string | null} undecided
 * @property {Enclosed | null} x_end
 * @property {Enclosed | null} duration
 * @property {number} impacts
 * @property {number} bits
 * @property {number} comparisons
 * @property {string[]} ties
 * @property {boolean | null} agrees
 * @property {ProvenEvent[]} events
 */

const PEG = 0;
const WALL = 1;

/** @type {Record<string, Key | undefined>} texts by the first words of the engine's reason */
const WHY = {
  wedged: "proof.wedged", balanced: "proof.balanced", escaped: "proof.escaped",
  "event budget": "proof.event-limit", "time budget": "proof.time-limit",
  "search budget": "proof.search-limit", "impulse budget": "proof.impulse-limit",
  "solver error": "proof.solver-error",
};

/** @param {Certificate} certificate @returns {string} */
export function provenWords({ certified, bin, unsettled, undecided, ...rest }) {
  if (!certified) return t("proof.open", { what: String(undecided) });
  const { x_end: x, duration, bits, comparisons: n, ties, agrees } = rest;
  const why = WHY[String(unsettled).split(":")[0]];
  const where = bin === null
    ? t("proof.none", { why: why ? t(why) : String(unsettled), n, bits })
    : t("proof.bin", { bin, x: x?.text ?? "", time: duration?.text ?? "", n, bits });
  const tied = ties.length ? [t("proof.ties", { ties: ties.join("; ") })] : [];
  return [where, ...tied, agrees ? t("proof.agrees") : t("proof.differs")].join(" ");
}

/**
 * Where two proven paths go different ways.
 * @param {Certificate} one
 * @param {Certificate} two
 * @returns {{common: number, apart: number, error: number} | null} common: how many events both have;
 *   apart: distance of the balls at the last of these, m; error: its bound, m; null if they never part
 */
export function partingOf(one, two) {
  const count = Math.max(one.events.length, two.events.length);
  for (let i = 0; i < count; i += 1) {
    const [a, b] = [one.events[i], two.events[i]];
    if (a && b && a[0] === b[0] && a[1] === b[1]) continue;
    if (i === 0) return { common: 0, apart: 0, error: 0 };
    const [before, beside] = [one.events[i - 1], two.events[i - 1]];
    return {
      common: i,
      apart: Math.hypot(before[3] - beside[3], before[4] - beside[4]),
      error: Math.SQRT2 * (before[5] + beside[5]),
    };
  }
  return null;
}

/** @param {ProvenEvent | undefined} event @returns {string} what the ball does there */
export function eventWords(event) {
  if (!event) return t("proof.ended");
  const [kind, index] = event;
  if (kind === PEG) return t("proof.hits-peg", { n: index });
  if (kind === WALL) return t("proof.hits-wall", { n: index });
  return [t("proof.rolls"), t("proof.changes"), t("proof.leaves"), t("event.lands", { n: index })][kind - 2];
}

/** @param {Certificate} one @param {Certificate} two @returns {string} */
export function partingWords(one, two) {
  if (!one.certified || !two.certified) {
    const open = one.certified ? two : one;
    return provenWords(open);
  }
  const parting = partingOf(one, two);
  if (!parting) return t("proof.same-way", { bin: String(one.bin) });
  const { common, apart, error } = parting;
  const [first, second] = [one, two].map(({ events }) => eventWords(events[common]));
  const parted = t("proof.parting", { n: common, one: first, two: second });
  if (common === 0) return parted;
  return `${parted} ${t("proof.apart", { apart: apart.toExponential(1), error: error.toExponential(0) })}`;
}
