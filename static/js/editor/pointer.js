// The pointer controller: turns pointer and keys on the board into changes of the board.

import { t } from "../texts/text.js";
import { zoom } from "../util/canvas.js";
import { hit, snap } from "./draft/draft.js";
import { moved, placeOf, tidy, withPeg, withSplit, withWall } from "./draft/element.js";
import { contains, groupOf, inside, membersOf, toggled } from "./draft/group.js";

/** @import { Board, Point, Wall } from "../model/board.js" */
/** @import { ElementRef, Ref } from "./draft/element.js" */
/** @import { EditorView } from "./view.js" */

const REACH = 14; // how far from an element a finger may be, CSS pixels
const FREE_STEP = 0.01; // m that an arrow key moves without a snapping grid
const LEAST_WALL = 0.02; // m; a shorter one is taken for a slip of the hand

/**
 * @typedef {object} Bench the current board, selection and tool
 * @property {Board} board
 * @property {Ref | null} selected
 * @property {"move" | "peg" | "wall" | "edge"} tool
 * @property {number} step of the snapping grid, m; 0 for none
 * @property {number} pegRadius of new pegs, m
 */

/**
 * Called for what the player does with pointer and keys.
 * @typedef {object} PointerListener
 * @property {(ref: Ref | null) => void} onSelect
 * @property {(board: Board, ref: Ref) => void} onPreview while an element is dragged
 * @property {(board: Board, ref: Ref | null) => void} onChange when a change is complete
 * @property {(text: string) => void} onSay
 * @property {() => void} onMark when the cross or the band has moved
 * @property {(command: Command) => void} onCommand
 *
 * @typedef {"next" | "last" | "and-next" | "and-last" | "all" | "delete" | "undo" | "redo" |
 *   "duplicate"} Command
 */

/**
 * @typedef {{x0: number, y0: number, x1: number, y1: number}} Band a rectangle drawn around
 *   elements, metres
 * @typedef {{ref: Ref, board: Board, from: Board, started: boolean, dx: number, dy: number}} Drag
 *   dx, dy: from the pointer to the element, metres
 */

export class PointerController {
  /** The cross that arrow keys move while nothing is selected, m. */
  cursor = { x: 0, y: 0 };
  /** @type {Band | null} */
  band = null;
  /** What was selected before the band. @type {Ref | null} */
  #kept = null;
  /** @type {Drag | null} */
  #drag = null;
  /** Where a finger touched an empty place: becomes a tap unless the finger moves. @type {Point | null} */
  #tap = null;
  /** @type {Point | null} */
  #wallFrom = null;

  /**
   * @param {EditorView} view
   * @param {() => Bench} bench
   * @param {PointerListener} listener
   */
  constructor(view, bench, listener) {
    this.view = view;
    this.bench = bench;
    this.listener = listener;
    const { field } = view;
    field.addEventListener("pointerdown", (event) => this.#down(event));
    field.addEventListener("pointermove", (event) => this.#move(event));
    field.addEventListener("pointerup", () => this.#up());
    // While a finger drags an element, the page must not scroll.
    field.addEventListener("touchstart", (event) => {
      if (this.#drag) event.preventDefault();
    }, { passive: false });
    field.addEventListener("pointercancel", () => this.#cancel());
    field.addEventListener("keydown", (event) => this.#key(event));
  }

  get dragging() {
    return this.#drag !== null;
  }

  /** @param {PointerEvent} event */
  #down(event) {
    const place = event.button === 0 && event.isPrimary ? this.view.placeOf(event) : null;
    if (!place) return;
    const { board, tool, selected } = this.bench();
    const found = hit(board, place.x, place.y, this.#reach);
    this.view.field.setPointerCapture(event.pointerId);
    const taken = tool === "move" || (tool === "peg" && found?.kind === "peg") ? found : null;
    if (taken && tool === "move" && event.shiftKey) this.#toggle(taken);
    else if (taken) this.#take(board, (contains(selected, taken) && selected) || taken, place);
    else if (tool === "wall") this.#takeNew("wall", place);
    else if (event.pointerType === "touch") this.#tap = place;
    else if (tool === "move") {
      this.band = { x0: place.x, y0: place.y, x1: place.x, y1: place.y };
      this.#kept = event.shiftKey ? selected : null;
    } else this.#hitEmpty(place);
  }

  /** @param {ElementRef} ref */
  #toggle(ref) {
    const { selected } = this.bench();
    const now = toggled(selected, ref);
    if (now === selected) this.listener.onSay(t("editor.only-parts"));
    else this.listener.onSelect(now);
  }

  /** Handles a click or a tap on an empty place. @param {Point} place */
  #hitEmpty(place) {
    const { tool } = this.bench();
    if (tool === "peg") this.#takeNew("peg", place);
    else if (tool === "edge") this.#split(place.x);
    else this.listener.onSelect(null);
  }

  /** How far from an element the pointer may be, m. */
  get #reach() {
    return (REACH * zoom()) / this.view.scale;
  }

  /**
   * Adds an element under the pointer, and begins to drag it.
   * @param {"peg" | "wall"} kind
   * @param {Point} place
   */
  #takeNew(kind, place) {
    const { board, pegRadius } = this.bench();
    const { x, y } = this.#snapped(place);
    const made = kind === "peg" ? withPeg(board, x, y, pegRadius) : withWall(board, x, y, x, y);
    this.#take(made.board, kind === "wall" ? { ...made.ref, end: 2 } : made.ref, place);
  }

  /** @param {Board} board @param {Ref} ref @param {Point} place */
  #take(board, ref, place) {
    const at = placeOf(board, ref);
    const started = board !== this.bench().board;
    this.#drag = {
      ref, board, from: board, started,
      dx: at.x - place.x, dy: at.y - place.y,
    };
    this.view.hold();
    this.listener.onSelect(ref.index < this.#count(ref) ? ref : null);
    if (started) this.listener.onPreview(board, ref);
  }

  /** How many elements of this kind the board had before the drag. @param {Ref} ref */
  #count({ kind }) {
    const { pegs, walls } = this.bench().board;
    if (kind === "peg") return pegs.length;
    return kind === "wall" ? walls.length : Number.POSITIVE_INFINITY;
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const drag = this.#drag;
    const place = this.view.placeOf(event);
    if (!place) return;
    const tap = this.#tap;
    // A finger that has moved too far does not tap.
    if (tap && Math.hypot(place.x - tap.x, place.y - tap.y) * this.view.scale > REACH) this.#tap = null;
    if (this.band) {
      Object.assign(this.band, { x1: place.x, y1: place.y });
      this.listener.onMark();
      return;
    }
    if (!drag) return;
    const { x, y } = this.#snapped({ x: place.x + drag.dx, y: place.y + drag.dy });
    const now = placeOf(drag.board, drag.ref);
    if (now.x === x && now.y === y) return;
    // A movement of less than 3 pixels is a click, not a drag.
    if (!drag.started && Math.hypot(x - now.x, y - now.y) * this.view.scale < 3) return;
    drag.started = true;
    drag.board = moved(drag.from, drag.ref, x, y);
    this.listener.onPreview(drag.board, drag.ref);
  }

  #up() {
    if (this.band) {
      const refs = [...membersOf(this.#kept), ...inside(this.bench().board, this.band)];
      this.band = null;
      this.listener.onSelect(groupOf(refs));
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
    const { ref } = drag;
    const isNew = ref.index >= this.#count(ref);
    if (ref.kind === "wall" && isNew && ref.end && lengthOf(drag.board.walls[ref.index]) < LEAST_WALL) {
      this.listener.onChange(this.bench().board, null);
      this.listener.onSay(t("editor.wall-drag"));
      return;
    }
    this.listener.onChange(drag.board, isNew && !ref.refs ? { kind: ref.kind, index: ref.index } : ref);
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

  /** @param {number} x */
  #split(x) {
    const { board, step } = this.bench();
    const made = withSplit(board, snap(x, step));
    if (made) this.listener.onChange(made.board, made.ref);
    else this.listener.onSay(t("editor.edge-there"));
  }

  /** @param {Point} point */
  #snapped({ x, y }) {
    const { step } = this.bench();
    return { x: snap(x, step), y: snap(y, step) };
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { key, ctrlKey, metaKey, altKey, shiftKey } = event;
    if (altKey) return;
    const command = commandOf(event);
    const arrow = ctrlKey || metaKey ? undefined : ARROWS[key];
    if (command) this.listener.onCommand(command);
    else if (arrow) this.#nudge(arrow, shiftKey);
    else if (key === "Enter" || key === " ") this.#put(shiftKey);
    else if (key === "Escape") this.#letGo();
    else return;
    event.preventDefault();
  }

  /** @param {[number, number]} given @param {boolean} far */
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

  /** Handles Enter at the cross. @param {boolean} also whether Shift is pressed */
  #put(also) {
    const { board, tool, pegRadius } = this.bench();
    const { x, y } = this.cursor;
    if (tool === "move") {
      const found = hit(board, x, y, this.#reach);
      if (also && found) this.#toggle(found);
      else this.listener.onSelect(found);
      if (!found) this.listener.onSay(t("editor.nothing-there"));
    } else if (tool === "peg") {
      // What keys add is not selected, so that the arrow keys still move the cross.
      this.listener.onChange(withPeg(board, x, y, pegRadius).board, null);
    } else if (tool === "edge") {
      this.#split(x);
      this.listener.onSelect(null);
    } else if (!this.#wallFrom) {
      this.#wallFrom = { x, y };
      this.listener.onSay(t("editor.wall-starts"));
    } else {
      const from = this.#wallFrom;
      this.#wallFrom = null;
      const made = withWall(board, from.x, from.y, x, y).board;
      if (Math.hypot(x - from.x, y - from.y) >= LEAST_WALL) this.listener.onChange(made, null);
      else this.listener.onSay(t("editor.wall-ends"));
    }
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

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

/** @param {KeyboardEvent} event @returns {Command | undefined} */
function commandOf({ key, ctrlKey, metaKey, shiftKey: shift }) {
  /** @type {Record<string, Command>} */
  const commands = ctrlKey || metaKey
    ? { z: shift ? "redo" : "undo", y: "redo", d: "duplicate", a: "all" }
    : {
      pagedown: shift ? "and-next" : "next", pageup: shift ? "and-last" : "last", delete: "delete", backspace: "delete",
    };
  return commands[key.toLowerCase()];
}

/** @param {Wall} wall */
function lengthOf({ x1, y1, x2, y2 }) {
  return Math.hypot(x2 - x1, y2 - y1);
}
