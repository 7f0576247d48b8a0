// The REST side: where things are, and errors that say what was wrong.

/** A reply that is not what was asked for; the message is fit to be shown. */
export class ApiError extends Error {
  /**
   * @param {string} message
   * @param {number} status 0 when no reply came
   * @param {ErrorOptions} [options]
   */
  constructor(message, status, options) {
    super(message, options);
    this.status = status;
  }
}

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<any>}
 */
export async function getJson(path, options) {
  const url = new URL(`api/v1/${path}`, document.baseURI);
  let response;
  try {
    response = await fetch(url, { headers: { accept: "application/json" }, ...options });
  } catch (cause) {
    throw new ApiError("The server does not answer.", 0, { cause });
  }
  if (response.ok) return response.json();
  throw new ApiError(await reason(response), response.status);
}

/** @param {Response} response @returns {Promise<string>} the problem detail, if it has one */
async function reason(response) {
  const fallback = `The server answered ${response.status} ${response.statusText}`.trim();
  if (!(response.headers.get("content-type") ?? "").includes("json")) return fallback;
  const problem = await response.json();
  return problem.detail ?? problem.title ?? fallback;
}

/**
 * What REST calls the board of a room: a preset's name, else its digest, registered for replays.
 * @param {{board: object, board_digest: string}} hello
 * @returns {Promise<string>}
 */
export async function boardAddress({ board, board_digest: digest }) {
  const { boards } = await getJson("boards");
  const known = boards.find((one) => one.digest === digest);
  if (known) return known.preset ? known.name : digest;
  const headers = { "content-type": "application/json" };
  await getJson("boards", { method: "POST", headers, body: JSON.stringify(board) });
  return digest;
}

/**
 * @param {{board: string, seed: string, x?: number | null}} drop
 * @param {string} [part] "" for the record, "/frames" for its states
 * @param {Record<string, string>} [query]
 */
export function dropPath({ board, seed, x }, part = "", query = {}) {
  const search = new URLSearchParams(query);
  if (x !== null && x !== undefined) search.set("x", String(x));
  const tail = search.size ? `?${search}` : "";
  return `drops/${encodeURIComponent(board)}/${encodeURIComponent(seed)}${part}${tail}`;
}

/** @param {string} room @returns {string} address of its socket */
export function socketUrl(room) {
  const url = new URL(`ws/rooms/${encodeURIComponent(room)}`, document.baseURI);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return url.href;
}

/** @param {{board: string, seed: string, x?: number | null}} drop @returns {string} its link */
export function replayLink({ board, seed, x }) {
  const search = new URLSearchParams({ board, seed });
  if (x !== null && x !== undefined) search.set("x", String(x));
  return `?${search}`;
}
