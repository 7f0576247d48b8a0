// Requests to the server's REST API, and the errors they can end with.

import { t } from "../texts/text.js";
import { ask } from "./ask.js";

/** @import { BoardList } from "./replies.js" */
/** @import { Hello } from "../model/messages.js" */

/** A request has failed; the message can be shown to the visitor. */
export class ApiError extends Error {
  /**
   * @param {string} message
   * @param {number} status of HTTP; 0 if there was no reply
   * @param {ErrorOptions & {field?: string | null}} [options] field: the invalid one
   */
  constructor(message, status, options) {
    super(message, options);
    this.status = status;
    this.field = options?.field ?? null;
  }
}

/** @param {unknown} error anything caught @returns {string} */
export function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<unknown>} the reply, of the type that net/replies.js gives for the path
 */
export async function getJson(path, options) {
  return JSON.parse(await getText(path, options));
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<string>} the reply, not parsed
 */
export async function getText(path, options) {
  return textOf(await request(path, options));
}

/**
 * @param {string} path below /api/v1
 * @param {unknown} body sent as JSON; a string is sent unchanged, so that no number loses digits
 * @returns {Promise<unknown>} the reply, of the type that net/replies.js gives for the path
 */
export function postJson(path, body) {
  const headers = { "content-type": "application/json", accept: "application/json" };
  const text = typeof body === "string" ? body : JSON.stringify(body);
  return getJson(path, { method: "POST", headers, body: text });
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<Response>} rejects with ApiError, unless the status is one of success
 */
export async function request(path, options) {
  let response;
  try {
    response = await ask(path, options);
  } catch (cause) {
    throw new ApiError(t("page.silent-server"), 0, { cause });
  }
  if (response.ok) return response;
  throw await refusal(response);
}

/** @param {Response} response @returns {Promise<string>} rejects with ApiError if the connection ends too early */
async function textOf(response) {
  try {
    return await response.text();
  } catch (cause) {
    throw new ApiError(t("page.silent-server"), 0, { cause });
  }
}

/** @param {Response} response @returns {Promise<ApiError>} with the problem detail, if it has one */
async function refusal(response) {
  const status = `${response.status} ${response.statusText}`.trim();
  const fallback = t("page.server-said", { status });
  if (!(response.headers.get("content-type") ?? "").includes("json")) {
    return new ApiError(fallback, response.status);
  }
  const { detail, title, field } = JSON.parse(await textOf(response));
  return new ApiError(detail ?? title ?? fallback, response.status, { field });
}

/**
 * The name by which REST knows a room's board: a preset's name, or the digest. A board that the server
 * does not know is registered first.
 * @param {Pick<Hello, "board" | "board_digest">} hello
 * @returns {Promise<string>}
 */
export async function boardAddress({ board, board_digest: digest }) {
  const { boards: [known] } = /** @type {BoardList} */ (await getJson(`boards?digest=${digest}`));
  if (known) return known.preset ? known.name : digest;
  await postJson("boards", board);
  return digest;
}

/**
 * @param {string} room
 * @param {string} [stream] of binary messages; by default the server chooses
 * @returns {string} URL of the room's WebSocket
 */
export function socketUrl(room, stream = "") {
  const url = new URL(`ws/rooms/${encodeURIComponent(room)}`, document.baseURI);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  if (stream) url.searchParams.set("stream", stream);
  return url.href;
}

export const SEEDS = "seeds"; // the stream without positions: the page computes each path
const SNAPSHOTS = "snapshots"; // the stream of positions at every tick

/**
 * @param {string | null} asked the stream in the page's address
 * @param {boolean} solves whether this page can compute paths
 * @returns {string[]} usable streams, the best first
 */
export const streamsFor = (asked, solves) => (solves && asked !== SNAPSHOTS ? [SEEDS, SNAPSHOTS] : [SNAPSHOTS]);
