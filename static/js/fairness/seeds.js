// Commitments, and the seed of a drop, which neither side can choose by itself: see docs/fairness.md.

import { bytesOfText, hexOf, hmac, joined, sha256 } from "./crypto.js";

/** @import { Bytes } from "./crypto.js" */

// Domain separators, so that an HMAC for one purpose is never valid for the other.
const DROP = bytesOfText("plinko drop 1\n");
const DRAW = bytesOfText("plinko draw 1\n");

/** @typedef {{server: Bytes, client: Bytes, board: Bytes}} Known both seeds, and the board's digest */

/** @param {Bytes} secret @returns {Promise<Bytes>} published before the secret is revealed */
export const commitment = (secret) => sha256(secret);

/**
 * @param {Known} known
 * @param {number} number of the drop in its session, from 0
 * @returns {Promise<string>} the first 64 bits of an HMAC, as a decimal seed
 */
export async function dropSeed(known, number) {
  return String(whole(await mac(DROP, known, number), 0, 8));
}

/**
 * Draws a bin by its weight, and a seed from that bin's list, in integer arithmetic.
 * @param {{weights: number[], seeds: string[][]}} draw
 * @param {Known} known
 * @param {number} number of the drop in its session, from 0
 * @returns {Promise<{bin: number, seed: string}>}
 */
export async function drawn({ weights, seeds }, known, number) {
  return pick({ weights, seeds }, await mac(DRAW, known, number));
}

/** @param {{weights: number[], seeds: string[][]}} draw @param {Bytes} bytes of an HMAC */
export function pick({ weights, seeds }, bytes) {
  const sum = weights.reduce((total, weight) => total + BigInt(weight), 0n);
  let place = (whole(bytes, 0, 16) * sum) >> 128n;
  const bin = weights.findIndex((weight) => (place -= BigInt(weight)) < 0n);
  const place64 = (whole(bytes, 16, 8) * BigInt(seeds[bin].length)) >> 64n;
  return { bin, seed: seeds[bin][Number(place64)] };
}

/** @param {Bytes} domain @param {Known} known @param {number} number @returns {Promise<Bytes>} */
function mac(domain, { server, client, board }, number) {
  const counted = new Uint8Array(8);
  new DataView(counted.buffer).setBigUint64(0, BigInt(number));
  return hmac(server, joined(domain, client, counted, board));
}

/** @param {Bytes} bytes @param {number} at @param {number} size @returns {bigint} big-endian */
const whole = (bytes, at, size) => BigInt(`0x${hexOf(bytes.subarray(at, at + size))}`);
