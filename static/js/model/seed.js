// Parsing of seeds that a player types, with messages for invalid ones; and random seeds.

import { t } from "../texts/text.js";

export const MAX_SEED = 2n ** 64n - 1n;

/**
 * @typedef {{ok: true, seed: string | null} | {ok: false, message: string}} SeedReading
 * seed is a decimal string, because JavaScript's numbers would round it; null if the field is empty.
 */

/** @param {string} text as typed @returns {SeedReading} */
export function readSeed(text) {
  const typed = text.trim();
  if (typed === "") return { ok: true, seed: null };
  if (!/^[0-9]+$/.test(typed)) {
    return { ok: false, message: `${t("seed.none", { typed: clip(typed) })} ${RULE}` };
  }
  // BigInt is slow for very long texts, which the length check refuses first.
  const digits = typed.replace(/^0+(?=\d)/, "");
  if (digits.length > 20 || BigInt(digits) > MAX_SEED) {
    return { ok: false, message: `${t("seed.large", { typed: clip(digits) })} ${RULE}` };
  }
  return { ok: true, seed: digits };
}

/** @param {string} seed decimal @returns {string} the next seed; 0 follows MAX_SEED */
export function seedAfter(seed) {
  return String((BigInt(seed) + 1n) & MAX_SEED);
}

/** @returns {string} decimal */
export function randomSeed() {
  return String(crypto.getRandomValues(new BigUint64Array(1))[0]);
}

const RULE = t("seed.rule", { most: String(MAX_SEED) });

/** @param {string} text */
function clip(text) {
  return text.length > 24 ? `${text.slice(0, 24)}…` : text;
}
