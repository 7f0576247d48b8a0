// The address of a drop: in links to the pages, and below /api/v1. Pure.

/**
 * The parameters of a drop. Numbers stay texts, so that no digit is lost.
 * @typedef {object} DropAddress
 * @property {string} board a preset's name or a digest; "" if the link's fragment contains the board
 * @property {string} seed
 * @property {string | number | null} [x] explicit start, m
 * @property {string | number | null} [aim] m; the seed draws the start around it
 * @property {string | null} [solver]
 * @property {string | null} [dt]
 * @property {string | null} [substeps]
 */

const OPTIONAL = /** @type {const} */ (["x", "aim", "solver", "dt", "substeps"]);

/** @param {URLSearchParams} search @returns {DropAddress} */
export function readDrop(search) {
  const [x, aim, solver, dt, substeps] = OPTIONAL.map((name) => search.get(name) || null);
  const [board, seed] = [search.get("board") ?? "", search.get("seed") ?? ""];
  return { board, seed, x, aim, solver, dt, substeps };
}

/** @param {DropAddress} drop @returns {URLSearchParams} the parameters that are set */
export function dropSearch(drop) {
  const search = new URLSearchParams();
  if (drop.board) search.set("board", drop.board);
  if (drop.seed) search.set("seed", drop.seed);
  return withOptional(search, drop);
}

/**
 * @param {DropAddress} drop
 * @param {string} [part] "" for the record, "/frames" for its states
 * @param {URLSearchParams} [query]
 * @returns {string} below /api/v1
 */
export function dropPath(drop, part = "", query = new URLSearchParams()) {
  const search = withOptional(new URLSearchParams(query), drop);
  const tail = search.size ? `?${search}` : "";
  return `drops/${encodeURIComponent(drop.board)}/${encodeURIComponent(drop.seed)}${part}${tail}`;
}

/** @param {DropAddress} drop @returns {string} link to its replay */
export function replayLink(drop) {
  return `replay.html?${dropSearch(drop)}`;
}

/** @param {URLSearchParams} search @param {DropAddress} drop */
function withOptional(search, drop) {
  for (const name of OPTIONAL) {
    const value = drop[name];
    if (value !== null && value !== undefined && value !== "") search.set(name, String(value));
  }
  return search;
}
