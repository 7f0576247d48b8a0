// Names of the preset boards and of the public tables they are played at. Pure.

export const MAIN_ROOM = "main";
export const MAIN_BOARD = "triangle-16"; // as a server has it unless it was set up otherwise
const KNOCKING = "interacting-"; // before a preset's name: its table on which balls knock each other

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

/** @param {string} name @returns {Choice | null} null when it is no preset offered here */
export function readBoardName(name) {
  if (name === "classic" || name === "galton") return { kind: name, rows: 16, risk: "medium" };
  const match = /^triangle-(\d+)(?:-(low|high))?$/.exec(name);
  if (!match) return null;
  const risk = match[2] === "low" || match[2] === "high" ? match[2] : "medium";
  return { kind: "triangle", rows: Number(match[1]), risk };
}

/**
 * @param {string} name of a preset
 * @param {string | null} mainBoard the main room's board, as far as it is known
 * @param {boolean} [knock] whether balls knock each other there
 * @returns {string} the id of the public room where it is played
 */
export function roomOf(name, mainBoard, knock = false) {
  if (knock) return `${KNOCKING}${name}`;
  return name === mainBoard ? MAIN_ROOM : name;
}
