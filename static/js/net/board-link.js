// A board in a link's fragment, as JSON, deflated and in base64url. Browsers do not send fragments to servers.

import { readJson } from "../solver/input/json-text.js";
import { t } from "../texts/text.js";

/** @import { Board } from "../model/board.js" */

const FRAGMENT = "board";
const MAX_TEXT = 4_000_000; // bytes of JSON; protects against links that unpack to far more than a board

/** @param {Board} board @returns {Promise<string>} letters, digits, - and _ */
export async function packBoard(board) {
  const text = new TextEncoder().encode(JSON.stringify(board));
  const packed = await through(text, new CompressionStream("deflate-raw"));
  let binary = "";
  for (const byte of packed) binary += String.fromCharCode(byte);
  return btoa(binary).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

/**
 * @param {string} packed
 * @returns {Promise<unknown>} the board, not yet checked; rejects with LinkError
 */
export async function unpackBoard(packed) {
  try {
    const binary = atob(packed.replace(/-/g, "+").replace(/_/g, "/"));
    const bytes = Uint8Array.from(binary, (letter) => letter.charCodeAt(0));
    const text = await through(bytes, new DecompressionStream("deflate-raw"), MAX_TEXT);
    return readJson(new TextDecoder("utf-8", { fatal: true }).decode(text), false);
  } catch (cause) {
    throw new LinkError(t("page.broken-link"), { cause });
  }
}

/** A link does not contain a board; the message can be shown to the visitor. */
export class LinkError extends Error {}

/** @param {string} hash of a location @returns {string | null} the packed board, if there is one */
export function boardInHash(hash) {
  return new URLSearchParams(hash.replace(/^#/, "")).get(FRAGMENT);
}

/**
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @param {CompressionStream | DecompressionStream} transform
 * @param {number} [limit]
 */
async function through(bytes, transform, limit = Number.POSITIVE_INFINITY) {
  const writer = transform.writable.getWriter();
  // Reading reports an error in the data. Without the catch, writing would report it a second time.
  writer.write(bytes).catch(() => {});
  writer.close().catch(() => {});
  /** @type {Uint8Array[]} */
  const chunks = [];
  let size = 0;
  for await (const chunk of streamOf(transform.readable)) {
    chunks.push(chunk);
    size += chunk.length;
    if (size > limit) throw new RangeError(`more than ${limit} bytes`);
  }
  const whole = new Uint8Array(size);
  let at = 0;
  for (const chunk of chunks) {
    whole.set(chunk, at);
    at += chunk.length;
  }
  return whole;
}

/** Iterates a stream, which not every browser can do itself. @param {ReadableStream<Uint8Array>} readable */
async function* streamOf(readable) {
  const reader = readable.getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      yield value;
    }
  } finally {
    await reader.cancel();
  }
}
