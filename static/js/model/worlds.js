// The worlds' names and looks; and boards of the house table with another gravity or material, for practice. Pure.

import { t } from "../texts/text.js";
import { HOUSE, readBoardName, WORLDS } from "./presets.js";

/** @import { Key } from "../texts/text.js" */
/** @import { Board } from "./board.js" */

/**
 * m/s^2 at the surface; for Jupiter, at the top of its clouds. The engine has the same values.
 * @type {Record<string, number>}
 */
export const GRAVITY = { Earth: 9.81, Moon: 1.62, Mars: 3.72, Jupiter: 24.79 };

/**
 * Lowest and highest measured restitution of pairs of bodies. The engine has the same table.
 * @type {Record<string, [number, number]>}
 */
export const RESTITUTION = {
  "Steel on steel": [0.8, 0.95],
  "Glass on glass": [0.93, 0.97],
  "Rubber on concrete": [0.75, 0.85],
  "Tennis ball on court": [0.7, 0.75],
  "Clay (putty)": [0.0, 0.1],
  "Billiard balls": [0.92, 0.98],
};

/** @type {Record<string, Key>} names for players */
const WORDS = {
  house: "place.house", earth: "world.earth", moon: "world.moon", mars: "world.mars", jupiter: "world.jupiter",
  glass: "place.glass", steel: "place.steel", rubber: "place.rubber",
  Earth: "world.earth", Moon: "world.moon", Mars: "world.mars", Jupiter: "world.jupiter",
  "Steel on steel": "world.steel", "Glass on glass": "world.glass", "Rubber on concrete": "world.rubber",
  "Tennis ball on court": "world.tennis", "Clay (putty)": "world.clay", "Billiard balls": "world.billiards",
  classic: "word.classic", galton: "word.galton", low: "word.low", high: "word.high",
};

/** The preset's own gravity or material. */
export const OWN = "own";

const BETWEEN = " · ";

/** @typedef {{gravity: string, material: string}} Custom names of gravities and materials, or OWN */

/** @param {string} name of a world, a gravity or a material @returns {string} in the page's language, if translated */
export function worldWords(name) {
  return name in WORDS ? t(WORDS[name]) : name;
}

/**
 * @param {string} boardName
 * @returns {string | null} the world whose look and sound the board has: a preset's own; of a board with a custom
 *   gravity or material, first by gravity; null for the house table's
 */
export function placeOf(boardName) {
  const { preset, gravity, material } = readWorldName(boardName);
  const custom = [gravity, material].map((part) => part.split(" ")[0].toLowerCase());
  const world = custom.find((name) => WORLDS.includes(name)) ?? readBoardName(preset)?.world ?? HOUSE;
  return world === HOUSE ? null : world;
}

/** @param {Custom} custom */
export function isOwn({ gravity, material }) {
  return gravity === OWN && material === OWN;
}

/** @param {string} name in RESTITUTION @returns {number} the middle of its range */
export function restitutionOf(name) {
  const [low, high] = RESTITUTION[name];
  return Math.round(500 * (low + high)) / 1000;
}

/**
 * The board with that gravity and material, and a name that says so.
 * @param {Board} board a preset
 * @param {Custom} custom
 */
export function transported(board, { gravity, material }) {
  const other = { ...board, name: worldName(board.name, { gravity, material }) };
  if (gravity !== OWN) other.gravity = GRAVITY[gravity];
  if (material !== OWN) {
    // An impact uses the larger restitution of the two bodies, so all of them get this one.
    const restitution = restitutionOf(material);
    other.ball = { ...board.ball, restitution };
    other.peg_material = { ...board.peg_material, restitution };
    other.wall_material = { ...board.wall_material, restitution };
  }
  return other;
}

/** @param {string} preset @param {Custom} custom @returns {string} "triangle-16 · Moon · Clay (putty)" */
export function worldName(preset, { gravity, material }) {
  return [preset, gravity, material].filter((part) => part !== OWN).join(BETWEEN);
}

/** @param {string} name of a board @returns {string} as players read it: "House · 16", "Moon · 12 · High" */
export function boardWords(name) {
  const { preset, gravity, material } = readWorldName(name);
  const known = readBoardName(preset);
  if (!known) return name;
  const { kind, world, rows, risk } = known;
  const words = kind === "triangle" ? [worldWords(world), String(rows)] : [worldWords(kind)];
  if (risk !== "medium") words.push(worldWords(risk));
  return [...words, ...[gravity, material].filter((part) => part !== OWN).map(worldWords)].join(BETWEEN);
}

/** @param {string} name @returns {{preset: string} & Custom} the inverse of worldName */
export function readWorldName(name) {
  const [preset, ...parts] = name.split(BETWEEN);
  return {
    preset,
    gravity: parts.find((part) => part in GRAVITY) ?? OWN,
    material: parts.find((part) => part in RESTITUTION) ?? OWN,
  };
}
