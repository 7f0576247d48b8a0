// Hands on the board: pointer and keys become changes of the board. Knows no panel and no server.

import { hit, moved, placeOf, snap, withPeg, withSplit, withWall } from "./draft.js";
import { contains, groupOf, inside, membersOf, toggled } from "./group.js";
import { zoom } from "./view.js";

const REACH = 14; // CSS pixels by which a finger may miss
const FREE_STEP = 0.01; // m that an arrow key moves when nothing is snapped to
const LEAST_WALL = 0.02; // m; a shorter one was a slip of the hand

/**
 * @typedef {object} Bench what the hands work on
 * @property {any} board
 * @property {import("./element.js").Ref | null} selected
 * @property {"move" | "peg" | "wall" | "edge"} tool
 * @property {number} step m, 0 for none
 * @property {number} pegRadius of new pegs, m
 */

/**
 * What the hands ask for.
 * @typedef {object} HandsListener
 * @property {(ref: import("./element.js").Ref | null) => void} onSelect
 * @property {(board: any) => void} onPreview while something is dragged
 * @property {(board: any, ref: import("./element.js").Ref | null) => void} onChange it is done
 * @property {(words: string) => void} onSay
 * @property {() => void} onMark the cross has moved
 * @property {(way: "next" | "last" | "and-next" | "and-last" | "all" | "delete" | "undo" | "redo" |
 *   "duplicate") => void} onCommand
 */

/** A rectangle drawn around elements, metres. @typedef {{x0: number, y0: number, x1: number, y1: number}} Band */

/** Follows pointer and keys on the field. */
export class EditorHands {
  /** The cross that keys move when nothing is selected, m. */
  cursor = { x: 0, y: 0 };
  /** @type {Band | null} */
  band = null;
  #kept = null; // what was selected before the band
  #drag = null;
  #tap = null; // where a finger is on an empty place: a tap, unless the page scrolls
  #wallFrom = null;

  /**
   * @param {import("./view.js").EditorView} view
   * @param {() => Bench} bench
   * @param {HandsListener} listener
   */
  constructor(view, bench, listener) {
    this.view = view;
    this.bench = bench;
    this.listener = listener;
    const { field } = view;
    field.addEventListener("pointerdown", (event) => this.#down(event));
    field.addEventListener("pointermove", (event) => this.#move(event));
    field.addEventListener("pointerup", () => this.#up());
    // A finger that has taken hold of something does not scroll the page.
    field.addEventListener("touchstart", (event) => {
      if (this.#drag) event.preventDefault();
    }, { passive: false });
    field.addEventListener("pointercancel", () => this.#cancel());
    field.addEventListener("keydown", (event) => this.#key(event));
  }

  get dragging() {
    return this.#drag !== null;
  }

  #down(event) {
    if (!this.view.geometry || event.button !== 0 || !event.isPrimary) return;
    const { board, tool, selected } = this.bench();
    const place = this.view.placeOf(event);
    const reach = (REACH * zoom()) / this.view.geometry.scale;
    const found = hit(board, place.x, place.y, reach);
    this.view.field.setPointerCapture(event.pointerId);
    const taken = found && (tool === "move" || (tool === "peg" && found.kind === "peg"));
    if (taken && tool === "move" && event.shiftKey) this.#toggle(found);
    else if (taken) this.#take(board, contains(selected, found) ? selected : found, place);
    else if (tool === "wall") this.#take(...this.#made("wall", place), place);
    else if (event.pointerType === "touch") this.#tap = place;
    else if (tool === "move") this.#stretch(place, event.shiftKey ? selected : null);
    else this.#hitEmpty(place);
  }

  #toggle(ref) {
    const { selected } = this.bench();
    const now = toggled(selected, ref);
    if (now === selected) this.listener.onSay("Only the start, pegs and walls can be selected together.");
    else this.listener.onSelect(now);
  }

  /** What a click or a tap on an empty place does. */
  #hitEmpty(place) {
    const { tool } = this.bench();
    if (tool === "peg") this.#take(...this.#made("peg", place), place);
    else if (tool === "edge") this.#split(place.x);
    else this.listener.onSelect(null);
  }

  /** A finger that has moved on is no tap. */
  #tremble(event) {
    const { x, y } = this.view.placeOf(event);
    if (Math.hypot(x - this.#tap.x, y - this.#tap.y) * this.view.geometry.scale > REACH) this.#tap = null;
  }

  #stretch({ x, y }, kept) {
    this.band = { x0: x, y0: y, x1: x, y1: y };
    this.#kept = kept;
  }

  /** A new element under the pointer, which is then dragged. */
  #made(kind, place) {
    const { board, pegRadius } = this.bench();
    const { x, y } = this.#snapped(place);
    const made = kind === "peg" ? withPeg(board, x, y, pegRadius) : withWall(board, x, y, x, y);
    return [made.board, kind === "wall" ? { ...made.ref, end: 2 } : made.ref];
  }

  #take(board, ref, place) {
    const at = placeOf(board, ref);
    this.#drag = {
      ref, board, from: board, started: board !== this.bench().board,
      dx: at.x - place.x, dy: at.y - place.y,
    };
    this.view.hold();
    this.listener.onSelect(ref.index < this.#count(ref) ? ref : null);
    if (this.#drag.started) this.listener.onPreview(board, ref);
  }

  /** Elements of this kind that the panels know of already. */
  #count({ kind }) {
    const { pegs, walls } = this.bench().board;
    return { peg: pegs.length, wall: walls.length }[kind] ?? Number.POSITIVE_INFINITY;
  }

  #move(event) {
    const drag = this.#drag;
    if (this.#tap) this.#tremble(event);
    if (this.band) {
      const { x, y } = this.view.placeOf(event);
      Object.assign(this.band, { x1: x, y1: y });
      this.listener.onMark();
      return;
    }
    if (!drag) return;
    const place = this.view.placeOf(event);
    const { x, y } = this.#snapped({ x: place.x + drag.dx, y: place.y + drag.dy });
    const now = placeOf(drag.board, drag.ref);
    if (now.x === x && now.y === y) return;
    // A click that trembles is no move.
    if (!drag.started && Math.hypot(x - now.x, y - now.y) * this.view.geometry.scale < 3) return;
    drag.started = true;
    drag.board = moved(drag.from, drag.ref, x, y);
    this.listener.onPreview(drag.board, drag.ref);
  }

  #up() {
    if (this.band) {
      this.#enclose();
      return;
    }
    const tap = this.#tap;
    this.#tap = null;
    if (tap) this.#hitEmpty(tap);
    const drag = this.#drag;
    if (!drag) return;
    this.#drag = null;
    this.view.release();
    if (!drag.started) return;
    const { kind, end, index } = drag.ref;
    const isNew = index >= this.#count(drag.ref);
    if (kind === "wall" && isNew && end && lengthOf(drag.board.walls[index]) < LEAST_WALL) {
      this.listener.onChange(this.bench().board, null);
      this.listener.onSay("A wall needs two ends: drag from one to the other.");
      return;
    }
    this.listener.onChange(drag.board, isNew ? { kind, index } : drag.ref);
  }

  /** Selects what the band is around. */
  #enclose() {
    const { band } = this;
    this.band = null;
    const refs = [...membersOf(this.#kept), ...inside(this.bench().board, band)];
    this.listener.onSelect(groupOf(refs));
  }

  #cancel() {
    this.#tap = null;
    if (this.band) {
      this.band = null;
      this.listener.onMark();
    }
    if (!this.#drag) return;
    this.#drag = null;
    this.view.release();
    this.listener.onChange(this.bench().board, this.bench().selected);
  }

  #split(x) {
    const { board, step } = this.bench();
    const made = withSplit(board, snap(x, step));
    if (made) this.listener.onChange(made.board, made.ref);
    else this.listener.onSay("There is an edge already.");
  }

  #snapped({ x, y }) {
    const { step } = this.bench();
    return { x: snap(x, step), y: snap(y, step) };
  }

  #key(event) {
    const { key, ctrlKey, metaKey, altKey, shiftKey } = event;
    if (altKey) return;
    const command = ctrlKey || metaKey ? commandOf(key.toLowerCase(), shiftKey) : plainCommand(key, shiftKey);
    const arrow = ctrlKey || metaKey ? undefined : ARROWS[key];
    if (command) this.listener.onCommand(command);
    else if (arrow) this.#nudge(arrow, shiftKey);
    else if (key === "Enter" || key === " ") this.#put(shiftKey);
    else if (key === "Escape") this.#letGo();
    else return;
    event.preventDefault();
  }

  #nudge([right, down], far) {
    const { board, selected, step } = this.bench();
    const by = (step || FREE_STEP) * (far ? 10 : 1);
    if (!selected) {
      this.cursor = this.#snapped({ x: this.cursor.x + right * by, y: this.cursor.y + down * by });
      this.listener.onSay(`x ${this.cursor.x}, y ${this.cursor.y} m`);
      this.listener.onMark();
      return;
    }
    const { x, y } = placeOf(board, selected);
    this.listener.onChange(moved(board, selected, tidy(x + right * by), tidy(y + down * by)), selected);
  }

  /** What Enter does at the cross. */
  #put(also) {
    const { board, tool, pegRadius } = this.bench();
    const { x, y } = this.cursor;
    if (tool === "move") {
      const found = hit(board, x, y, (REACH * zoom()) / this.view.geometry.scale);
      if (also && found) this.#toggle(found);
      else this.listener.onSelect(found);
      if (!found) this.listener.onSay("Nothing lies there.");
    } else if (tool === "peg") {
      this.#add(withPeg(board, x, y, pegRadius));
    } else if (tool === "edge") {
      this.#split(x);
      this.listener.onSelect(null);
    } else if (!this.#wallFrom) {
      this.#wallFrom = { x, y };
      this.listener.onSay("The wall starts here. Go on, and press Enter at its other end.");
    } else {
      const from = this.#wallFrom;
      this.#wallFrom = null;
      if (Math.hypot(x - from.x, y - from.y) >= LEAST_WALL) this.#add(withWall(board, from.x, from.y, x, y));
      else this.listener.onSay("A wall needs two ends.");
    }
  }

  /** What keys add stays unselected, so that the cross can go on to the next place. */
  #add({ board }) {
    this.listener.onChange(board, null);
  }

  #letGo() {
    const { board, selected } = this.bench();
    this.#wallFrom = null;
    if (this.#drag || this.band) this.#cancel();
    if (!selected) return;
    this.cursor = this.#snapped(placeOf(board, selected));
    this.listener.onSelect(null);
  }
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function plainCommand(key, shift) {
  const way = { PageDown: "next", PageUp: "last" }[key];
  if (way) return shift ? `and-${way}` : way;
  return { Delete: "delete", Backspace: "delete" }[key];
}

function commandOf(key, shift) {
  return { z: shift ? "redo" : "undo", y: "redo", d: "duplicate", a: "all" }[key];
}

function lengthOf({ x1, y1, x2, y2 }) {
  return Math.hypot(x2 - x1, y2 - y1);
}

/** Sums of decimal steps written in decimal. */
function tidy(value) {
  return Number(value.toPrecision(12));
}
