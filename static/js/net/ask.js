// Sends requests to the server's REST API. In the pages of `plinko site`, which have no server, ask.device.js takes this
// module's place: there, every X.device.js takes that of X.js.

export const hasServer = true;

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<Response>}
 */
export function ask(path, options) {
  return fetch(new URL(`api/v1/${path}`, document.baseURI), { headers: { accept: "application/json" }, ...options });
}
