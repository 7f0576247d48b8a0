// What each side commits to, and the seed of a drop that neither could choose: see docs/fairness.md.

import { bytesOfText, hmac, joined, sha256 } from "./crypto.js";

/** @import { Bytes } from "./crypto.js" */

const DOMAIN = bytesOfText("plinko drop 1\n");

/** @param {Bytes} secret @returns {Promise<Bytes>} what is published of it at first */
export const commitment = (secret) => sha256(secret);

/**
 * @param {{server: Bytes, client: Bytes, board: Bytes}} known both secrets, and the board's digest
 * @param {number} number of the drop in its session, from 0
 * @returns {Promise<string>} the first 64 bits of an HMAC, as a decimal seed
 */
export async function dropSeed({ server, client, board }, number) {
  const counted = new Uint8Array(8);
  new DataView(counted.buffer).setBigUint64(0, BigInt(number));
  const mac = await hmac(server, joined(DOMAIN, client, counted, board));
  return String(new DataView(mac.buffer).getBigUint64(0));
}
