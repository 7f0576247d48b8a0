// Which elements make a selection: one, or a group of the start, pegs and whole walls. Pure.

import { t } from "../../texts/text.js";

/** @import { Board } from "../../model/board.js" */
/** @import { ElementRef, Ref } from "./element.js" */
/** @import { Band } from "../pointer.js" */

const KINDS = ["drop", "peg", "wall"];

/** @param {Ref | null} ref @returns {ElementRef[]} the elements of a selection */
export function membersOf(ref) {
  if (!ref) return [];
  return ref.refs ?? [ref];
}

/** @param {Ref | null} one @param {Ref | null} two @returns {boolean} */
export function sameElement(one, two) {
  if (!one || !two) return one === two;
  return one.kind === two.kind && one.index === two.index && one.end === two.end;
}

/**
 * @param {ElementRef} ref
 * @returns {ElementRef | null} the element that can be in a group (for a wall's end, the wall), or null
 */
function groupable({ kind, index }) {
  return KINDS.includes(kind) ? { kind, index } : null;
}

/** @param {ElementRef[]} refs @returns {Ref | null} a group of those that can be grouped; if it is only one, the element itself */
export function groupOf(refs) {
  /** @type {ElementRef[]} */
  const chosen = [];
  for (const ref of refs.map(groupable)) {
    if (ref && !chosen.some((one) => sameElement(one, ref))) chosen.push(ref);
  }
  if (chosen.length > 1) return { kind: "group", index: 0, refs: chosen };
  return chosen[0] ?? null;
}

/**
 * @param {Ref | null} selected
 * @param {ElementRef} ref
 * @returns {Ref | null} the selection with the element added, or removed if it was selected
 */
export function toggled(selected, ref) {
  const whole = groupable(ref);
  const members = membersOf(selected).map(groupable).filter((one) => one !== null);
  if (!whole) return selected;
  const left = members.filter((one) => !sameElement(one, whole));
  return groupOf(left.length < members.length ? left : [...members, whole]);
}

/**
 * @param {Ref | null} selected
 * @param {ElementRef} ref
 * @returns {boolean} whether the selection is a group that contains the element, or the wall of this end
 */
export function contains(selected, ref) {
  const whole = groupable(ref);
  return selected?.refs?.some((one) => sameElement(one, whole)) ?? false;
}

/**
 * The elements inside a rectangle; of walls, those with both ends inside.
 * @param {Board} board
 * @param {Band} band
 * @returns {ElementRef[]}
 */
export function inside({ pegs, walls, drop }, { x0, y0, x1, y1 }) {
  /** @param {number} x @param {number} y */
  const within = (x, y) =>
    x >= Math.min(x0, x1) && x <= Math.max(x0, x1) && y >= Math.min(y0, y1) && y <= Math.max(y0, y1);
  /** @type {ElementRef[]} */
  const found = within(drop.x, drop.y) ? [{ kind: "drop", index: 0 }] : [];
  pegs.forEach(({ x, y }, index) => within(x, y) && found.push({ kind: "peg", index }));
  walls.forEach((wall, index) => {
    if (within(wall.x1, wall.y1) && within(wall.x2, wall.y2)) found.push({ kind: "wall", index });
  });
  return found;
}

/** @param {{refs: ElementRef[]}} group @returns {string} "the start, 3 pegs and 1 wall" */
export function named({ refs }) {
  /** @param {ElementRef["kind"]} kind */
  const count = (kind) => refs.filter((ref) => ref.kind === kind).length;
  const parts = [
    count("drop") ? t("editor.the-start") : "",
    count("peg") ? t("editor.pegs", { n: count("peg") }) : "",
    count("wall") ? t("editor.walls", { n: count("wall") }) : "",
  ].filter(Boolean);
  if (parts.length === 1) return parts[0];
  return t("editor.and", { some: parts.slice(0, -1).join(", "), last: parts[parts.length - 1] });
}
