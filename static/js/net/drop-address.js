// A drop's address: in links to the pages that show it, and below /api/v1. Pure.

/**
 * What decides a drop. Numbers stay the texts they were given as, so that no digit is lost.
 * @typedef {object} DropAddress
 * @property {string} board preset's name or digest; "" when the link's fragment holds the board
 * @property {string} seed
 * @property {string | number | null} [x] explicit start, m
 * @property {string | null} [solver]
 * @property {string | null} [dt]
 * @property {string | null} [substeps]
 */

const OPTIONAL = ["x", "solver", "dt", "substeps"];

/** @param {URLSearchParams} search @returns {DropAddress} */
export function readDrop(search) {
  const optional = OPTIONAL.map((name) => [name, search.get(name) || null]);
  return {
    board: search.get("board") ?? "",
    seed: search.get("seed") ?? "",
    ...Object.fromEntries(optional),
  };
}

/** @param {DropAddress} drop @returns {URLSearchParams} what of it is set */
export function dropSearch(drop) {
  const search = new URLSearchParams();
  for (const name of ["board", "seed"]) if (drop[name]) search.set(name, drop[name]);
  return withOptional(search, drop);
}

/**
 * @param {DropAddress} drop
 * @param {string} [part] "" for the record, "/frames" for its states
 * @param {Record<string, string>} [query]
 * @returns {string} below /api/v1
 */
export function dropPath(drop, part = "", query = {}) {
  const search = withOptional(new URLSearchParams(query), drop);
  const tail = search.size ? `?${search}` : "";
  return `drops/${encodeURIComponent(drop.board)}/${encodeURIComponent(drop.seed)}${part}${tail}`;
}

/** @param {DropAddress} drop @returns {string} link to its replay */
export function replayLink(drop) {
  return `replay.html?${dropSearch(drop)}`;
}

function withOptional(search, drop) {
  for (const name of OPTIONAL) {
    const value = drop[name];
    if (value !== null && value !== undefined && value !== "") search.set(name, String(value));
  }
  return search;
}
