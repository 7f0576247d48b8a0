// The rows of the editor's panels: which fields each part of a board has, and their labels. Pure.

import { labelOf } from "../model/board.js";
import { t } from "../texts/text.js";
import { capital } from "../util/format.js";
import { named } from "./draft/group.js";

/** @import { Key } from "../texts/text.js" */
/** @import { Board } from "../model/board.js" */
/** @import { Ref } from "./draft/element.js" */

/** @typedef {{path: string, label: string, step?: number, text?: boolean}} Row of a panel; step: of the arrow keys;
 *  text: whether the value is a text instead of a number */

/** @type {Row[]} the numbers of the whole board */
export const BOARD_ROWS = [
  { path: "gravity", label: t("editor.row-gravity"), step: 0.1 },
  { path: "drag", label: t("editor.row-drag"), step: 0.1 },
  { path: "ball.radius", label: t("editor.row-ball-radius"), step: 0.005 },
  { path: "ball.density", label: t("editor.row-ball-density"), step: 0.1 },
  { path: "ball.restitution", label: t("editor.row-ball-bounce"), step: 0.05 },
  { path: "ball.friction", label: t("editor.row-ball-friction"), step: 0.05 },
  { path: "peg_material.restitution", label: t("editor.row-peg-bounce"), step: 0.05 },
  { path: "peg_material.friction", label: t("editor.row-peg-friction"), step: 0.05 },
  { path: "wall_material.restitution", label: t("editor.row-wall-bounce"), step: 0.05 },
  { path: "wall_material.friction", label: t("editor.row-wall-friction"), step: 0.05 },
  { path: "bins.y", label: t("editor.row-bins-y"), step: 0.05 },
  { path: "drop.jitter", label: t("editor.row-start-spread"), step: 0.05 },
  { path: "drop.reach", label: t("editor.row-start-within"), step: 0.05 },
  { path: "drop.aim", label: t("editor.row-aim-within"), step: 0.01 },
];

/** @param {Ref} ref @param {Board} board @returns {Row[]} the fields of an element; a group has none */
export function rowsOf({ kind, index }, board) {
  if (kind === "peg") return fieldsOf(`pegs[${index}]`, ["x", "y"]).concat({ path: `pegs[${index}].radius`, label: t("editor.row-radius") });
  if (kind === "wall") return fieldsOf(`walls[${index}]`, ["x1", "y1", "x2", "y2"]);
  if (kind === "edge") return [{ path: `bins.edges[${index}]`, label: "x, m" }];
  if (kind === "bin") return binRows(board, index);
  if (kind === "group") return [];
  return [
    { path: "drop.x", label: "x, m" },
    { path: "drop.y", label: "y, m" },
    { path: "drop.jitter", label: t("editor.row-spread") },
  ];
}

/** @param {Board} board @param {number} index @returns {Row[]} with the prize's colour if there is a prize */
function binRows(board, index) {
  const label = `bins.labels[${index}]`;
  const rows = [
    { path: `bins.multipliers[${index}]`, label: t("editor.row-pays"), step: 0.1 },
    { path: `${label}.text`, label: t("editor.row-prize"), text: true },
  ];
  return labelOf(board, index) ? [...rows, { path: `${label}.colour`, label: t("editor.row-prize-colour"), text: true }] : rows;
}

/** @param {string} path of an element @param {string[]} names of its fields @returns {Row[]} in metres */
function fieldsOf(path, names) {
  return names.map((name) => ({ path: `${path}.${name}`, label: `${name}, m` }));
}

/** @type {Record<Exclude<Ref["kind"], "drop" | "group">, Key>} */
const NAMES = {
  peg: "editor.name-peg", wall: "editor.name-wall", edge: "editor.name-edge", bin: "editor.name-bin",
};

/** @param {Ref} ref @returns {string} its name for people */
export function nameOf(ref) {
  if (ref.refs) return capital(named(ref));
  const { kind, index, end } = ref;
  if (kind === "drop") return t("word.start");
  if (kind === "wall" && end) return t("editor.name-wall-end", { index, end });
  return t(NAMES[kind], { index });
}
