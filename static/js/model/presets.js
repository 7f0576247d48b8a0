// Names of the preset boards, and ids of their public rooms. Pure.

export const MAIN_ROOM = "main";
export const MAIN_BOARD = "triangle-16"; // the server's default
const KNOCKING = "interacting-"; // + preset name: id of its room with touching balls

/**
 * @typedef {object} Choice
 * @property {"triangle" | "classic" | "galton"} kind
 * @property {number} rows of a triangle
 * @property {"low" | "medium" | "high"} risk of a triangle
 */

/** @param {Choice} choice @returns {string} the preset's name */
export function boardName({ kind, rows, risk }) {
  if (kind !== "triangle") return kind;
  return risk === "medium" ? `triangle-${rows}` : `triangle-${rows}-${risk}`;
}

/** @param {string} name @returns {Choice | null} null if the page does not offer it */
export function readBoardName(name) {
  if (name === "classic" || name === "galton") return { kind: name, rows: 16, risk: "medium" };
  const match = /^triangle-(\d+)(?:-(low|high))?$/.exec(name);
  if (!match) return null;
  const risk = match[2] === "low" || match[2] === "high" ? match[2] : "medium";
  return { kind: "triangle", rows: Number(match[1]), risk };
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
