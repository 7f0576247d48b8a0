// The edited board on two canvases: the board, and over it the marks of marks.js.

import { announceShape, StageFit } from "../board/stage-fit.js";
import { paintBoard } from "../paint/board.js";
import { layOut, ratioOf } from "../paint/geometry.js";
import { fitted } from "../util/canvas.js";
import { byId, parentOf } from "../util/dom.js";
import { placeOf } from "./draft/element.js";
import { BELOW, paintAround, paintBand, paintCursor, paintGrid, paintHandles } from "./marks.js";

/** @import { Board, Point } from "../model/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { ElementRef, Ref } from "./draft/element.js" */
/** @import { Band } from "./pointer.js" */

const HEADROOM = 16; // CSS pixels above the highest part
const BUBBLE_GAP = 18; // CSS pixels between a message and its element

/**
 * @typedef {object} Marks
 * @property {Ref | null} selected
 * @property {ElementRef[]} problems
 * @property {Point | null} cursor metres
 * @property {number} step of the grid, m; 0 for none
 * @property {Band | null} band the selection rectangle
 */

/** Draws the board and its marks, and converts pointer positions to metres. */
export class EditorView {
  /** @type {Geometry | null} */
  geometry = null;
  /** @type {Board | null} */
  #board = null;
  #held = false;

  /** @param {Theme} theme @param {(geometry: Geometry) => void} onLayout */
  constructor(theme, onLayout) {
    this.theme = theme;
    this.still = byId("board-still", HTMLCanvasElement);
    this.field = byId("field", HTMLCanvasElement);
    this.onLayout = onLayout;
    this.fit = new StageFit(parentOf(this.still), () => this.#layOut());
    theme.onChange(() => this.#layOut());
  }

  /** @param {Board} board */
  setBoard(board) {
    this.#board = board;
    if (this.#held && this.geometry) this.#paint(board, this.geometry);
    else this.#layOut();
  }

  /** Keeps the board's place and size until `release`, so that it does not move under a dragging pointer. */
  hold() {
    this.#held = true;
  }

  release() {
    this.#held = false;
    this.#layOut();
  }

  /** CSS pixels a metre. */
  get scale() {
    return this.geometry?.scale ?? 1;
  }

  /** @param {PointerEvent} event @returns {Point | null} metres */
  placeOf(event) {
    if (!this.geometry) return null;
    const box = this.field.getBoundingClientRect();
    const { x, py, scale } = this.geometry;
    return { x: x(event.clientX - box.left), y: (event.clientY - box.top - py(0)) / scale };
  }

  /** @param {Marks} marks */
  draw(marks) {
    if (!this.geometry || !this.#board) return;
    const ctx = fitted(this.field, this.geometry);
    const { palette } = this.theme;
    const sheet = { ctx, board: this.#board, geometry: this.geometry };
    if (marks.step > 0) paintGrid(sheet, marks.step, palette.rail);
    paintHandles(sheet, palette);
    for (const ref of marks.problems) {
      paintAround(sheet, ref, { colour: palette.flash, width: 6 });
      paintAround(sheet, ref, { colour: palette.accent, width: 3.5 });
    }
    if (marks.selected) {
      paintAround(sheet, marks.selected, { colour: palette.railShade, width: 5 });
      paintAround(sheet, marks.selected, { colour: palette.trayMark, width: 2.5 });
    }
    if (marks.band) paintBand(sheet, marks.band, palette);
    if (marks.cursor) paintCursor(sheet, marks.cursor, palette);
  }

  /** Places a message next to an element, within the board. @param {HTMLElement} bubble @param {Ref} ref */
  placeBubble(bubble, ref) {
    if (!this.geometry || !this.#board) return;
    const { px, py, width, height } = this.geometry;
    const { x, y } = placeOf(this.#board, ref);
    const wide = Math.min(bubble.offsetWidth, width);
    const left = Math.min(width - wide - 4, Math.max(4, px(x) - wide / 2));
    const below = py(y) + BUBBLE_GAP;
    const tall = bubble.offsetHeight;
    const top = below + tall < height ? below : py(y) - BUBBLE_GAP - tall;
    bubble.style.setProperty("--bubble-x", `${left}px`);
    bubble.style.setProperty("--bubble-y", `${Math.max(4, top)}px`);
  }

  #layOut() {
    const board = this.#board;
    if (!board) return;
    announceShape(ratioOf(board));
    const width = this.fit.fit((wide) => withHeadroom(layOut(board, wide), board).height);
    if (width === 0) return;
    this.geometry = withHeadroom(layOut(board, width), board);
    this.fit.shine(this.geometry.height, this.geometry.dropY);
    this.#paint(board, this.geometry);
    this.onLayout(this.geometry);
  }

  /** @param {Board} board @param {Geometry} geometry */
  #paint(board, geometry) {
    for (const canvas of [this.still, this.field]) canvas.style.height = `${geometry.height}px`;
    paintBoard({ ctx: fitted(this.still, geometry), geometry, board, look: this.theme }, board.drop.slots ?? []);
  }
}

/**
 * The geometry, moved down so that elements above the start are on the canvas too, as are the knobs below the bins.
 * @param {Geometry} geometry
 * @param {Board} board
 */
function withHeadroom(geometry, { walls, pegs }) {
  const tops = [...walls.flatMap(({ y1, y2 }) => [y1, y2]), ...pegs.map(({ y, radius }) => y - radius)];
  const more = Math.max(0, HEADROOM - geometry.py(Math.min(Number.POSITIVE_INFINITY, ...tops)));
  return {
    ...geometry,
    height: Math.round(geometry.height + more + BELOW),
    binTop: geometry.binTop + more,
    dropY: geometry.dropY + more,
    aimBottom: geometry.aimBottom + more,
    /** @param {number} y */
    py: (y) => geometry.py(y) + more,
  };
}
