// SHA-256, HMAC and Ed25519 by WebCrypto, and conversion between bytes and hexadecimal digits.

import { shownJson } from "../solver/input/json-text.js";

const utf8 = new TextEncoder();

/** @typedef {Uint8Array<ArrayBuffer>} Bytes */

/** Whether WebCrypto exists: browsers offer it only over HTTPS and on localhost. @returns {boolean} */
export const hasCrypto = () => Boolean(globalThis.crypto?.subtle);

/** @param {string} text @returns {Bytes} */
export const bytesOfText = (text) => utf8.encode(text);

/**
 * @param {unknown} digits
 * @param {string} name of the value, for the error
 * @param {number} [size] required number of bytes
 * @returns {Bytes}
 */
export function bytesOfHex(digits, name, size = 32) {
  if (typeof digits !== "string" || digits.length !== 2 * size || !/^[0-9a-fA-F]*$/.test(digits)) {
    throw new RangeError(`${name} ${shownJson(digits)} is not ${2 * size} hexadecimal digits`);
  }
  return Uint8Array.from(digits.match(/../g) ?? [], (pair) => parseInt(pair, 16));
}

/** @param {Uint8Array} bytes @returns {string} */
export function hexOf(bytes) {
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** @param {...Uint8Array} parts @returns {Bytes} their concatenation */
export function joined(...parts) {
  const whole = new Uint8Array(parts.reduce((size, part) => size + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

/** @param {Bytes} bytes @returns {Promise<Bytes>} */
export async function sha256(bytes) {
  return new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
}

/** @param {Bytes} key @param {Bytes} message @returns {Promise<Bytes>} HMAC-SHA256 */
export async function hmac(key, message) {
  const how = { name: "HMAC", hash: "SHA-256" };
  const imported = await crypto.subtle.importKey("raw", key, how, false, ["sign"]);
  return new Uint8Array(await crypto.subtle.sign("HMAC", imported, message));
}

/**
 * Whether an Ed25519 signature is valid; throws in a browser without Ed25519.
 * @param {Bytes} key
 * @param {Bytes} signature
 * @param {Bytes} message
 */
export async function isSigned(key, signature, message) {
  const imported = await crypto.subtle.importKey("raw", key, "Ed25519", false, ["verify"]);
  return crypto.subtle.verify("Ed25519", imported, signature, message);
}
