// The REST side: where things are, and errors that say what was wrong.

import { t } from "../texts/text.js";

/** @import { BoardList } from "./replies.js" */
/** @import { Hello } from "../model/messages.js" */

/** A reply that is not what was asked for; the message is fit to be shown. */
export class ApiError extends Error {
  /**
   * @param {string} message
   * @param {number} status 0 when no reply came
   * @param {ErrorOptions & {field?: string | null}} [options] field: where the bad value is
   */
  constructor(message, status, options) {
    super(message, options);
    this.status = status;
    this.field = options?.field ?? null;
  }
}

/** @param {unknown} error that was caught @returns {string} what it says */
export function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<unknown>} the reply, of a type that net/replies.js has for the path
 */
export async function getJson(path, options) {
  return (await request(path, options)).json();
}

/**
 * @param {string} path below /api/v1
 * @param {unknown} body sent as JSON; a string is sent as it is, to the last bit of its numbers
 * @returns {Promise<unknown>} the reply, of a type that net/replies.js has for the path
 */
export function postJson(path, body) {
  const headers = { "content-type": "application/json", accept: "application/json" };
  const text = typeof body === "string" ? body : JSON.stringify(body);
  return getJson(path, { method: "POST", headers, body: text });
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<Response>} a good one; rejects with ApiError
 */
export async function request(path, options) {
  const url = new URL(`api/v1/${path}`, document.baseURI);
  let response;
  try {
    response = await fetch(url, { headers: { accept: "application/json" }, ...options });
  } catch (cause) {
    throw new ApiError(t("page.silent-server"), 0, { cause });
  }
  if (response.ok) return response;
  throw await refusal(response);
}

/** @param {Response} response @returns {Promise<ApiError>} with the problem detail, if it has one */
async function refusal(response) {
  const status = `${response.status} ${response.statusText}`.trim();
  const fallback = t("page.server-said", { status });
  if (!(response.headers.get("content-type") ?? "").includes("json")) {
    return new ApiError(fallback, response.status);
  }
  const { detail, title, field } = await response.json();
  return new ApiError(detail ?? title ?? fallback, response.status, { field });
}

/**
 * What REST calls the board of a room: a preset's name, else its digest, registered for replays.
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
 * @param {string} [stream] what its binary messages are to be; the server's default without it
 * @returns {string} address of its socket
 */
export function socketUrl(room, stream = "") {
  const url = new URL(`ws/rooms/${encodeURIComponent(room)}`, document.baseURI);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  if (stream) url.searchParams.set("stream", stream);
  return url.href;
}
