// Names of the preset boards, and ids of their public rooms. Pure.

export const MAIN_ROOM = "main";
export const MAIN_BOARD = "triangle-16"; // the server's default
const KNOCKING = "interacting-"; // + preset name: id of its room with touching balls

/** The house table, whose triangles are called triangle-8 to triangle-16. */
export const HOUSE = "house";

/** Each has triangles of its own physics and payouts, such as moon-16-high. The engine has the same list. */
export const WORLDS = [HOUSE, "earth", "moon", "mars", "jupiter", "glass", "steel", "rubber"];

/**
 * @typedef {object} Choice
 * @property {"triangle" | "classic" | "galton"} kind
 * @property {string} world of a triangle, one of WORLDS
 * @property {number} rows of a triangle
 * @property {"low" | "medium" | "high"} risk of a triangle
 */

/** @param {Choice} choice @returns {string} the preset's name */
export function boardName({ kind, world, rows, risk }) {
  if (kind !== "triangle") return kind;
  const plain = `${world === HOUSE ? kind : world}-${rows}`;
  return risk === "medium" ? plain : `${plain}-${risk}`;
}

/** @param {string} name @returns {Choice | null} null if the page does not offer it */
export function readBoardName(name) {
  if (name === "classic" || name === "galton") return { kind: name, world: HOUSE, rows: 16, risk: "medium" };
  const match = /^([a-z]+)-(8|9|1[0-6])(?:-(low|high))?$/.exec(name);
  const world = match?.[1] === "triangle" ? HOUSE : match?.[1];
  if (!match || !world || match[1] === HOUSE || !WORLDS.includes(world)) return null;
  const risk = match[3] === "low" || match[3] === "high" ? match[3] : "medium";
  return { kind: "triangle", world, rows: Number(match[2]), risk };
}

/**
 * @param {string} name of a preset
 * @param {string | null} mainBoard the main room's board, null if not known
 * @param {boolean} [knock] whether balls touch each other
 * @returns {string} the id of the preset's public room
 */
export function roomOf(name, mainBoard, knock = false) {
  if (knock) return `${KNOCKING}${name}`;
  return name === mainBoard ? MAIN_ROOM : name;
}
