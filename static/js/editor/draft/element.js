// Elements of a board: their places, and functions that return a new board with them moved, copied or removed. Pure.

import { groupOf, membersOf } from "./group.js";

/** @import { Bins, Board, Point } from "../../model/board.js" */

const LEAST_BIN = 1e-3; // smallest distance between two edges, m

/**
 * An element of a board: the start, a peg, a wall or one of its ends, an edge between bins, a bin.
 * @typedef {{kind: "drop" | "peg" | "wall" | "edge" | "bin", index: number, end?: 1 | 2,
 *   refs?: undefined}} ElementRef
 *
 * A selection: an element, or a group of the start, pegs and whole walls (see group.js).
 * @typedef {ElementRef | {kind: "group", index: number, end?: undefined, refs: ElementRef[]}} Ref
 */

/**
 * A new board, and its new element.
 * @template {Ref} [R=Ref]
 * @typedef {{board: Board, ref: R}} Made
 */

/** @param {Board} board @param {Ref} ref @returns {Point} metres; for a group, of its first element */
export function placeOf(board, ref) {
  if (ref.refs) return placeOf(board, ref.refs[0]);
  const { kind, index, end } = ref;
  const { pegs, walls, bins, drop } = board;
  if (kind === "drop") return { x: drop.x, y: drop.y };
  if (kind === "peg") return { x: pegs[index].x, y: pegs[index].y };
  if (kind === "edge") return { x: bins.edges[index], y: bins.y };
  if (kind === "bin") return { x: (bins.edges[index] + bins.edges[index + 1]) / 2, y: bins.y };
  const { x1, y1, x2, y2 } = walls[index];
  if (end === 1) return { x: x1, y: y1 };
  if (end === 2) return { x: x2, y: y2 };
  return { x: (x1 + x2) / 2, y: (y1 + y2) / 2 };
}

/**
 * @param {Board} board
 * @param {Ref} ref
 * @param {number} x
 * @param {number} y
 * @returns {Board} with the element at (x, y), or as near as its neighbours allow; of a group, the first one
 */
export function moved(board, ref, x, y) {
  const from = placeOf(board, ref);
  return membersOf(ref).reduce((made, one) => shifted(made, one, x - from.x, y - from.y), board);
}

/** @param {Board} board @param {ElementRef} ref @param {number} dx @param {number} dy @returns {Board} */
function shifted(board, { kind, index, end }, dx, dy) {
  const { pegs, walls, bins, drop } = board;
  /** @param {Point} place */
  const there = ({ x, y }) => ({ x: tidy(x + dx), y: tidy(y + dy) });
  if (kind === "drop") return { ...board, drop: { ...drop, ...there(drop) } };
  if (kind === "peg") return { ...board, pegs: pegs.with(index, { ...pegs[index], ...there(pegs[index]) }) };
  if (kind === "edge") return withEdge(board, index, tidy(bins.edges[index] + dx));
  if (kind === "bin") return { ...board, bins: { ...bins, y: tidy(bins.y + dy) } };
  const wall = { ...walls[index] };
  if (end !== 2) Object.assign(wall, { x1: tidy(wall.x1 + dx), y1: tidy(wall.y1 + dy) });
  if (end !== 1) Object.assign(wall, { x2: tidy(wall.x2 + dx), y2: tidy(wall.y2 + dy) });
  return { ...board, walls: walls.with(index, wall) };
}

/** @param {Board} board @param {number} index @param {number} x */
function withEdge(board, index, x) {
  const { edges } = board.bins;
  const low = index > 0 ? edges[index - 1] + LEAST_BIN : Number.NEGATIVE_INFINITY;
  const high = index < edges.length - 1 ? edges[index + 1] - LEAST_BIN : Number.POSITIVE_INFINITY;
  const at = Math.min(high, Math.max(low, x));
  return { ...board, bins: { ...board.bins, edges: edges.with(index, at) } };
}

/**
 * @param {Board} board
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @returns {Made<ElementRef>}
 */
export function withPeg(board, x, y, radius) {
  /** @type {ElementRef} */
  const ref = { kind: "peg", index: board.pegs.length };
  return { board: { ...board, pegs: [...board.pegs, { x, y, radius }] }, ref };
}

/**
 * @param {Board} board
 * @param {number} x1
 * @param {number} y1
 * @param {number} x2
 * @param {number} y2
 * @returns {Made<ElementRef>}
 */
export function withWall(board, x1, y1, x2, y2) {
  /** @type {ElementRef} */
  const ref = { kind: "wall", index: board.walls.length };
  return { board: { ...board, walls: [...board.walls, { x1, y1, x2, y2 }] }, ref };
}

/** @param {Bins} bins @param {Bins["labels"]} labels @returns {Bins} with the labels, if any bin has one */
export const withLabels = (bins, labels) => (labels?.some(Boolean) ? { ...bins, labels } : bins);

/**
 * Divides a bin at x, or adds one at the side if x lies beyond the outer edges.
 * @param {Board} board
 * @param {number} x
 * @returns {Made<ElementRef> | null} null if x is too close to an edge
 */
export function withSplit(board, x) {
  const { edges, multipliers, labels, y } = board.bins;
  if (edges.some((edge) => Math.abs(edge - x) < LEAST_BIN)) return null;
  const at = edges.findIndex((edge) => edge > x);
  const index = at < 0 ? edges.length : at;
  const split = Math.min(multipliers.length - 1, Math.max(0, index - 1));
  const bins = withLabels({
    y, edges: edges.toSpliced(index, 0, x), multipliers: multipliers.toSpliced(index, 0, multipliers[split]),
  }, labels?.toSpliced(index, 0, labels[split]));
  return { board: { ...board, bins }, ref: { kind: "edge", index } };
}

/**
 * @param {Board} board
 * @param {Ref} ref
 * @returns {Board | null} without the element; null if the board needs it. The start in a group remains
 */
export function without(board, ref) {
  const { kind, index } = ref;
  if (kind === "drop") return null;
  if (kind === "edge" || kind === "bin") return withoutBin(board, kind, index);
  /** @param {ElementRef["kind"]} of */
  const gone = (of) => new Set(membersOf(ref).filter((one) => one.kind === of).map((one) => one.index));
  const [pegs, walls] = [gone("peg"), gone("wall")];
  return {
    ...board,
    pegs: board.pegs.filter((_, number) => !pegs.has(number)),
    walls: board.walls.filter((_, number) => !walls.has(number)),
  };
}

/** @param {Board} board @param {"edge" | "bin"} kind @param {number} index @returns {Board | null} null without another bin */
function withoutBin(board, kind, index) {
  const { edges, multipliers, labels, y } = board.bins;
  if (multipliers.length === 1) return null;
  // Without an edge its two bins become one, with the left one's multiplier.
  const edge = kind === "edge" ? index : index + (index < multipliers.length - 1 ? 1 : 0);
  const bin = kind === "edge" ? Math.min(index, multipliers.length - 1) : index;
  return {
    ...board,
    bins: withLabels(
      { y, edges: edges.toSpliced(edge, 1), multipliers: multipliers.toSpliced(bin, 1) },
      labels?.toSpliced(bin, 1),
    ),
  };
}

/**
 * @param {Board} board
 * @param {Ref} ref
 * @param {number} by
 * @returns {Made | null} with copies of the pegs and walls, shifted by `by` metres in x
 */
export function duplicated(board, ref, by) {
  /** @type {Made<ElementRef>[]} */
  const copies = [];
  for (const { kind, index } of membersOf(ref)) {
    const made = copies.at(-1)?.board ?? board;
    const [peg, wall] = [board.pegs[index], board.walls[index]];
    if (kind === "peg") copies.push(withPeg(made, peg.x + by, peg.y, peg.radius));
    if (kind === "wall") copies.push(withWall(made, wall.x1 + by, wall.y1, wall.x2 + by, wall.y2));
  }
  const all = groupOf(copies.map((copy) => copy.ref));
  return all && { board: copies[copies.length - 1].board, ref: all };
}

/** Rounds to 12 digits, so that sums of decimal steps stay short. @param {number} value */
export function tidy(value) {
  return Number(value.toPrecision(12));
}
