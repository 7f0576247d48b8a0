// Several elements of a board at once: the start, pegs and whole walls, moved and copied together. Pure.

import { counted } from "../util/format.js";
import { duplicated as copied, placeOf, sameElement } from "./element.js";

/** @typedef {import("./element.js").Ref} Ref */

const KINDS = ["drop", "peg", "wall"];

/** @param {Ref | null} ref @returns {Ref[]} what a selection consists of */
export function membersOf(ref) {
  if (!ref) return [];
  return ref.refs ?? [ref];
}

/** @param {Ref} ref @returns {Ref | null} what of it can be in a group: of a wall's end the wall */
export function groupable({ kind, index }) {
  return KINDS.includes(kind) ? { kind, index } : null;
}

/** @param {Ref[]} refs @returns {Ref | null} the least that stands for all that can be grouped */
export function groupOf(refs) {
  const chosen = [];
  for (const ref of refs.map(groupable)) {
    if (ref && !chosen.some((one) => sameElement(one, ref))) chosen.push(ref);
  }
  if (chosen.length > 1) return { kind: "group", index: 0, refs: chosen };
  return chosen[0] ?? null;
}

/** @returns {Ref | null} the selection with an element more, or without it if it had it */
export function toggled(selected, ref) {
  const whole = groupable(ref);
  const members = membersOf(selected).map(groupable).filter(Boolean);
  if (!whole) return selected;
  const left = members.filter((one) => !sameElement(one, whole));
  return groupOf(left.length < members.length ? left : [...members, whole]);
}

/** @returns {boolean} whether an element, or a wall by its end, is in a group */
export function contains(selected, ref) {
  return selected?.refs?.some((one) => sameElement(one, groupable(ref))) ?? false;
}

/** All that lies within a rectangle; walls with both their ends. @returns {Ref[]} */
export function inside({ pegs, walls, drop }, { x0, y0, x1, y1 }) {
  const within = (x, y) =>
    x >= Math.min(x0, x1) && x <= Math.max(x0, x1) && y >= Math.min(y0, y1) && y <= Math.max(y0, y1);
  const found = within(drop.x, drop.y) ? [{ kind: "drop", index: 0 }] : [];
  pegs.forEach(({ x, y }, index) => within(x, y) && found.push({ kind: "peg", index }));
  walls.forEach((wall, index) => {
    if (within(wall.x1, wall.y1) && within(wall.x2, wall.y2)) found.push({ kind: "wall", index });
  });
  return found;
}

/** @returns {boolean} whether two selections have the same elements in the same order */
export function same(one, two) {
  const [these, those] = [membersOf(one), membersOf(two)];
  return these.length === those.length && these.every((ref, i) => sameElement(ref, those[i]));
}

/** @returns {any} the board with a group so that its first element is at (x, y) */
export function moved(board, refs, x, y) {
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

/** @returns {any} the board without the pegs and walls of a group; its start stays */
export function without(board, refs) {
  const gone = (kind) => new Set(refs.filter((ref) => ref.kind === kind).map((ref) => ref.index));
  const [pegs, walls] = [gone("peg"), gone("wall")];
  return {
    ...board,
    pegs: board.pegs.filter((_, index) => !pegs.has(index)),
    walls: board.walls.filter((_, index) => !walls.has(index)),
  };
}

/** @returns {{board: any, ref: Ref} | null} the board with copies beside, which are the new group */
export function duplicated(board, refs, by) {
  let made = board;
  const copies = [];
  for (const ref of refs) {
    const one = copied(made, ref, by);
    if (!one) continue;
    made = one.board;
    copies.push(one.ref);
  }
  return copies.length ? { board: made, ref: groupOf(copies) } : null;
}

/** @returns {string} "the start, 3 pegs and 1 wall" */
export function named({ refs }) {
  const count = (kind) => refs.filter((ref) => ref.kind === kind).length;
  const parts = [
    count("drop") ? "the start" : "",
    count("peg") ? counted(count("peg"), "peg") : "",
    count("wall") ? counted(count("wall"), "wall") : "",
  ].filter(Boolean);
  return parts.length > 1 ? `${parts.slice(0, -1).join(", ")} and ${parts.at(-1)}` : parts[0];
}

/** Sums of decimal steps written in decimal. */
function tidy(value) {
  return Number(value.toPrecision(12));
}
