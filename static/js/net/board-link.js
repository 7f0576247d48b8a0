// A board in a link's fragment, as JSON, deflated and in base64url. Browsers do not send fragments to servers.

import { readJson } from "../solver/input/json-text.js";
import { t } from "../texts/text.js";

/** @import { Board } from "../model/board.js" */

const FRAGMENT = "board";
const MAX_TEXT = 4_000_000; // bytes of JSON; protects against links that unpack to far more than a board

/** @param {Board} board @returns {Promise<string>} letters, digits, - and _ */
export async function packBoard(board) {
  const packed = await through(JSON.stringify(board), new CompressionStream("deflate-raw"));
  const binary = Array.from(packed, (byte) => String.fromCharCode(byte)).join("");
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
 * @param {BlobPart} content
 * @param {CompressionStream | DecompressionStream} transform
 * @param {number} [limit] of the result, bytes
 */
async function through(content, transform, limit = Number.POSITIVE_INFINITY) {
  let size = 0;
  const count = new TransformStream({
    transform(chunk, out) {
      size += chunk.length;
      if (size > limit) throw new RangeError(`more than ${limit} bytes`);
      out.enqueue(chunk);
    },
  });
  const whole = new Response(new Blob([content]).stream().pipeThrough(transform).pipeThrough(count));
  return new Uint8Array(await whole.arrayBuffer());
}
