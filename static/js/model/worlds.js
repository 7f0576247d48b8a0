// Preset boards with another gravity or another material. Pure.

import { t } from "../texts/text.js";

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
  Earth: "world.earth", Moon: "world.moon", Mars: "world.mars", Jupiter: "world.jupiter",
  "Steel on steel": "world.steel", "Glass on glass": "world.glass", "Rubber on concrete": "world.rubber",
  Glass: "place.glass", Steel: "place.steel", Rubber: "place.rubber",
  "Tennis ball on court": "world.tennis", "Clay (putty)": "world.clay", "Billiard balls": "world.billiards",
};

/** The preset's own gravity or material. */
export const OWN = "own";

const BETWEEN = " · ";

/** @typedef {{gravity: string, material: string}} World names of presets, or OWN */

/** @param {string} name of a gravity, a material or a table @returns {string} in the page's language, if translated */
export function worldWords(name) {
  return name in WORDS ? t(WORDS[name]) : name;
}

/**
 * Tables with their own look and sound: one tap sets gravity and material. The first is the default.
 * @type {(World & {name: string})[]}
 */
export const TABLES = [
  { name: "Earth", gravity: OWN, material: OWN },
  { name: "Moon", gravity: "Moon", material: OWN },
  { name: "Mars", gravity: "Mars", material: OWN },
  { name: "Jupiter", gravity: "Jupiter", material: OWN },
  { name: "Glass", gravity: OWN, material: "Glass on glass" },
  { name: "Steel", gravity: OWN, material: "Steel on steel" },
  { name: "Rubber", gravity: OWN, material: "Rubber on concrete" },
];

/**
 * @param {string} boardName
 * @returns {string | null} the name in TABLES whose look and sound the board has, first by gravity, then by
 *   material; null for the default
 */
export function placeOf(boardName) {
  const { gravity, material } = readWorldName(boardName);
  const [, ...away] = TABLES;
  const own = away.find((table) => table.gravity === gravity && gravity !== OWN)
    ?? away.find((table) => table.material === material && material !== OWN);
  return own?.name ?? null;
}

/** @param {World} world */
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
 * @param {World} world
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

/** @param {string} preset @param {World} world @returns {string} "triangle-16 · Moon · Clay (putty)" */
export function worldName(preset, { gravity, material }) {
  return [preset, gravity, material].filter((part) => part !== OWN).join(BETWEEN);
}

/** @param {string} name @returns {{preset: string} & World} the inverse of worldName */
export function readWorldName(name) {
  const [preset, ...parts] = name.split(BETWEEN);
  return {
    preset,
    gravity: parts.find((part) => part in GRAVITY) ?? OWN,
    material: parts.find((part) => part in RESTITUTION) ?? OWN,
  };
}
