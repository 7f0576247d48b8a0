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
 * @returns {Board} with the element at (x, y), or as near as its neighbours allow
 */
export function moved(board, ref, x, y) {
  if (ref.refs) return movedGroup(board, ref.refs, x, y);
  const { kind, index, end } = ref;
  if (kind === "drop") return { ...board, drop: { ...board.drop, x, y } };
  if (kind === "peg") return { ...board, pegs: replaced(board.pegs, index, { x, y }) };
  if (kind === "edge") return withEdge(board, index, x);
  if (kind === "bin") return { ...board, bins: { ...board.bins, y } };
  if (end) {
    const change = end === 1 ? { x1: x, y1: y } : { x2: x, y2: y };
    return { ...board, walls: replaced(board.walls, index, change) };
  }
  const from = placeOf(board, ref);
  const [dx, dy] = [x - from.x, y - from.y];
  const { x1, y1, x2, y2 } = board.walls[index];
  const change = { x1: x1 + dx, y1: y1 + dy, x2: x2 + dx, y2: y2 + dy };
  return { ...board, walls: replaced(board.walls, index, change) };
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
 * @template T
 * @param {T[]} items
 * @param {number} index
 * @param {Partial<T>} change
 * @returns {T[]} a copy with some fields of one item changed
 */
function replaced(items, index, change) {
  return items.with(index, { ...items[index], ...change });
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
 * @returns {Board | null} without the element; null if the board needs it
 */
export function without(board, ref) {
  if (ref.refs) return withoutGroup(board, ref.refs);
  const { kind, index } = ref;
  if (kind === "peg") return { ...board, pegs: board.pegs.toSpliced(index, 1) };
  if (kind === "wall") return { ...board, walls: board.walls.toSpliced(index, 1) };
  const { edges, multipliers, labels, y } = board.bins;
  if (kind === "drop" || multipliers.length === 1) return null;
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
  if (ref.refs) return duplicatedGroup(board, ref.refs, by);
  const { kind, index } = ref;
  if (kind === "peg") {
    const { x, y, radius } = board.pegs[index];
    return withPeg(board, x + by, y, radius);
  }
  if (kind !== "wall") return null;
  const { x1, y1, x2, y2 } = board.walls[index];
  return withWall(board, x1 + by, y1, x2 + by, y2);
}

/**
 * @param {Board} board
 * @param {ElementRef[]} refs
 * @param {number} x
 * @param {number} y
 * @returns {Board} with the group moved so that its first element is at (x, y)
 */
function movedGroup(board, refs, x, y) {
  const from = placeOf(board, refs[0]);
  const [dx, dy] = [x - from.x, y - from.y];
  const [pegs, walls] = [[...board.pegs], [...board.walls]];
  let { drop } = board;
  for (const { kind, index } of refs) {
    if (kind === "drop") drop = { ...drop, x: tidy(drop.x + dx), y: tidy(drop.y + dy) };
    if (kind === "peg") {
      const peg = pegs[index];
      pegs[index] = { ...peg, x: tidy(peg.x + dx), y: tidy(peg.y + dy) };
    }
    if (kind === "wall") {
      const { x1, y1, x2, y2 } = walls[index];
      walls[index] = { x1: tidy(x1 + dx), y1: tidy(y1 + dy), x2: tidy(x2 + dx), y2: tidy(y2 + dy) };
    }
  }
  return { ...board, pegs, walls, drop };
}

/**
 * @param {Board} board
 * @param {ElementRef[]} refs
 * @returns {Board} without the group's pegs and walls; the start remains
 */
function withoutGroup(board, refs) {
  /** @param {ElementRef["kind"]} kind */
  const gone = (kind) => new Set(refs.filter((ref) => ref.kind === kind).map((ref) => ref.index));
  const [pegs, walls] = [gone("peg"), gone("wall")];
  return {
    ...board,
    pegs: board.pegs.filter((_, index) => !pegs.has(index)),
    walls: board.walls.filter((_, index) => !walls.has(index)),
  };
}

/**
 * @param {Board} board
 * @param {ElementRef[]} refs
 * @param {number} by
 * @returns {Made | null} with copies of its pegs and walls, which are the new group
 */
function duplicatedGroup(board, refs, by) {
  let made = board;
  const copies = [];
  for (const ref of refs) {
    const one = duplicated(made, ref, by);
    if (!one) continue;
    made = one.board;
    copies.push(...membersOf(one.ref));
  }
  const ref = groupOf(copies);
  return ref && { board: made, ref };
}

/** Rounds to 12 digits, so that sums of decimal steps stay short. @param {number} value */
export function tidy(value) {
  return Number(value.toPrecision(12));
}
