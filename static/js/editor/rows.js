// What the editor's panels call the parts of a board, and the numbers that each part has. Pure.

import { capital } from "../util/format.js";
import { named } from "./draft/group.js";

/** @import { Ref } from "./draft/element.js" */

/** @typedef {{path: string, label: string, step?: number}} Row of a panel; step: of the arrow keys */

/** @type {Row[]} the numbers of the whole board */
export const BOARD_ROWS = [
  { path: "gravity", label: "Gravity, m/s²", step: 0.1 },
  { path: "drag", label: "Drag, 1/s", step: 0.1 },
  { path: "ball.radius", label: "Ball radius, m", step: 0.005 },
  { path: "ball.density", label: "Ball density, kg/m²", step: 0.1 },
  { path: "ball.restitution", label: "Ball bounce", step: 0.05 },
  { path: "ball.friction", label: "Ball friction", step: 0.05 },
  { path: "peg_material.restitution", label: "Peg bounce", step: 0.05 },
  { path: "peg_material.friction", label: "Peg friction", step: 0.05 },
  { path: "wall_material.restitution", label: "Wall bounce", step: 0.05 },
  { path: "wall_material.friction", label: "Wall friction", step: 0.05 },
  { path: "bins.y", label: "Bins at y, m", step: 0.05 },
  { path: "drop.jitter", label: "Start spread, m", step: 0.05 },
  { path: "drop.reach", label: "Start within, m", step: 0.05 },
  { path: "drop.aim", label: "Aim within, m", step: 0.01 },
];

/** @param {Ref} ref @returns {Row[]} the numbers of an element; a group has none */
export function rowsOf({ kind, index }) {
  if (kind === "peg") return fieldsOf(`pegs[${index}]`, ["x", "y", "radius"]);
  if (kind === "wall") return fieldsOf(`walls[${index}]`, ["x1", "y1", "x2", "y2"]);
  if (kind === "edge") return [{ path: `bins.edges[${index}]`, label: "x, m" }];
  if (kind === "bin") return [{ path: `bins.multipliers[${index}]`, label: "Pays", step: 0.1 }];
  if (kind === "group") return [];
  return [
    { path: "drop.x", label: "x, m" },
    { path: "drop.y", label: "y, m" },
    { path: "drop.jitter", label: "Spread, m" },
  ];
}

/** @param {string} path of an element @param {string[]} names of its fields @returns {Row[]} in metres */
function fieldsOf(path, names) {
  return names.map((name) => ({ path: `${path}.${name}`, label: `${name}, m` }));
}

/** @param {Ref} ref @returns {string} what it is called */
export function nameOf(ref) {
  if (ref.refs) return capital(named(ref));
  const { kind, index, end } = ref;
  if (kind === "drop") return "Start";
  if (kind === "wall" && end) return `Wall ${index}, end ${end}`;
  return `${capital(kind)} ${index}`;
}
