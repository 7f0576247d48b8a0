// The board being edited on its canvases: the board itself, and over it grid, selection, problems.

import { byId } from "../util/dom.js";
import { placeOf } from "./draft.js";
import { membersOf } from "./group.js";
import { announceShape, layOut } from "../paint/geometry.js";
import { binBox, paintBoard } from "../paint/board.js";
import { paintRing } from "../paint/marks.js";
import { fitted } from "../board/stage.js";

const LEAST_GRID = 9; // CSS pixels between the grid's dots; closer, they would be a wash
const HEADROOM = 16; // CSS pixels above the highest part
const BUBBLE_GAP = 18; // CSS pixels between a message and what it is about

/**
 * What lies over the board.
 * @typedef {object} Marks
 * @property {import("./element.js").Ref | null} selected
 * @property {import("./element.js").Ref[]} problems
 * @property {{x: number, y: number} | null} cursor metres
 * @property {number} step of the grid, m; 0 for none
 * @property {import("./pointer.js").Band | null} band that is drawn around elements
 */

/** Draws a board and marks; turns pointer places into metres. */
export class EditorView {
  /** @type {import("../paint/geometry.js").Geometry | null} */
  geometry = null;
  #board = null;
  #held = false;

  /** @param {import("../paint/theme.js").Theme} theme @param {() => void} onLayout */
  constructor(theme, onLayout) {
    this.theme = theme;
    this.still = byId("board-still");
    this.field = byId("field");
    this.onLayout = onLayout;
    new ResizeObserver(() => this.#layOut()).observe(this.still.parentElement);
    theme.onChange(() => this.#layOut());
  }

  /** @param {any} board */
  setBoard(board) {
    this.#board = board;
    if (this.#held) this.#paint();
    else this.#layOut();
  }

  /** While something is dragged the board keeps its place and size under the pointer. */
  hold() {
    this.#held = true;
  }

  release() {
    this.#held = false;
    this.#layOut();
  }

  /** @param {PointerEvent} event @returns {{x: number, y: number}} metres */
  placeOf(event) {
    const box = this.field.getBoundingClientRect();
    const { x, py, scale } = this.geometry;
    return { x: x(event.clientX - box.left), y: (event.clientY - box.top - py(0)) / scale };
  }

  /** @param {Marks} marks */
  draw(marks) {
    if (!this.geometry) return;
    const ctx = fitted(this.field, this.geometry);
    const { palette } = this.theme;
    if (marks.step > 0) this.#paintGrid(ctx, marks.step, palette.rail);
    this.#paintHandles(ctx, palette);
    for (const ref of marks.problems) {
      this.#paintAround(ctx, ref, { colour: palette.flash, width: 6 });
      this.#paintAround(ctx, ref, { colour: palette.accent, width: 3.5 });
    }
    if (marks.selected) {
      this.#paintAround(ctx, marks.selected, { colour: palette.railShade, width: 5 });
      this.#paintAround(ctx, marks.selected, { colour: palette.trayMark, width: 2.5 });
    }
    if (marks.band) this.#paintBand(ctx, marks.band, palette);
    if (marks.cursor) this.#paintCursor(ctx, marks.cursor, palette);
  }

  #paintBand(ctx, { x0, y0, x1, y1 }, { flash }) {
    const { px, py } = this.geometry;
    const box = [px(x0), py(y0), px(x1) - px(x0), py(y1) - py(y0)];
    ctx.fillStyle = flash;
    ctx.globalAlpha = 0.12;
    ctx.fillRect(...box);
    ctx.globalAlpha = 1;
    ctx.strokeStyle = flash;
    ctx.lineWidth = 1.5 * zoom();
    ctx.setLineDash([6 * zoom(), 4 * zoom()]);
    ctx.strokeRect(...box);
    ctx.setLineDash([]);
  }

  /** Puts a message beside an element, within the board. */
  placeBubble(bubble, ref) {
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
    const width = this.still.parentElement.clientWidth;
    if (!this.#board || width === 0) return;
    announceShape(this.#board);
    this.geometry = withHeadroom(layOut(this.#board, width), this.#board);
    this.#paint();
    this.onLayout();
  }

  #paint() {
    for (const canvas of [this.still, this.field]) {
      canvas.style.height = `${this.geometry.height}px`;
    }
    const ctx = fitted(this.still, this.geometry);
    paintBoard(ctx, this.geometry, this.#board, this.#board.drop.slots ?? [], this.theme);
  }

  #paintGrid(ctx, step, colour) {
    const { px, py, x, scale, width, height } = this.geometry;
    let wide = step;
    while (wide * scale < LEAST_GRID) wide *= 2;
    ctx.fillStyle = colour;
    ctx.globalAlpha = 0.22;
    const top = -py(0) / scale;
    for (let i = Math.ceil(x(0) / wide); i * wide < x(width); i += 1) {
      for (let j = Math.ceil(top / wide); py(j * wide) < height; j += 1) {
        ctx.fillRect(px(i * wide) - 0.75, py(j * wide) - 0.75, 1.5, 1.5);
      }
    }
    ctx.globalAlpha = 1;
  }

  /** What can be taken hold of: wall ends, edges between bins, the start. */
  #paintHandles(ctx, palette) {
    const { px, py, scale } = this.geometry;
    const { walls, bins, drop, ball } = this.#board;
    ctx.fillStyle = palette.flash;
    ctx.strokeStyle = palette.railShade;
    ctx.lineWidth = 1.5;
    const size = 5 * zoom();
    const knob = (x, y) => {
      ctx.beginPath();
      ctx.arc(x, y, size, 0, 2 * Math.PI);
      ctx.fill();
      ctx.stroke();
    };
    for (const { x1, y1, x2, y2 } of walls) {
      knob(px(x1), py(y1));
      knob(px(x2), py(y2));
    }
    const middle = this.geometry.binTop + this.geometry.binHeight / 2;
    for (const edge of bins.edges) knob(px(edge), middle);
    const ring = { colour: palette.flash, width: 2 * zoom(), dash: [4 * zoom(), 3 * zoom()] };
    paintRing(ctx, px(drop.x), py(drop.y), Math.max(5, ball.radius * scale), ring);
  }

  #paintAround(ctx, ref, look) {
    for (const one of membersOf(ref)) this.#paintAroundOne(ctx, one, look);
  }

  #paintAroundOne(ctx, ref, { colour, width }) {
    const { px, py, scale } = this.geometry;
    const { x, y } = placeOf(this.#board, ref);
    ctx.strokeStyle = colour;
    ctx.lineWidth = width * zoom();
    ctx.lineCap = "round";
    ctx.beginPath();
    if (ref.kind === "wall" && !ref.end) {
      const { x1, y1, x2, y2 } = this.#board.walls[ref.index];
      ctx.moveTo(px(x1), py(y1));
      ctx.lineTo(px(x2), py(y2));
    } else if (ref.kind === "bin") {
      const box = binBox(this.geometry, this.#board, ref.index);
      ctx.rect(box.x, box.y, box.width, box.height);
    } else {
      const { binTop, binHeight } = this.geometry;
      const { pegs, ball } = this.#board;
      const size = { peg: pegs[ref.index]?.radius, drop: ball.radius }[ref.kind] ?? 0;
      const atY = ref.kind === "edge" ? binTop + binHeight / 2 : py(y);
      ctx.arc(px(x), atY, Math.max(8 * zoom(), size * scale + 5 * zoom()), 0, 2 * Math.PI);
    }
    ctx.stroke();
  }

  #paintCursor(ctx, { x, y }, { flash, railShade }) {
    const { px, py } = this.geometry;
    for (const [colour, width] of [[railShade, 4], [flash, 2]]) {
      ctx.strokeStyle = colour;
      ctx.lineWidth = width;
      ctx.beginPath();
      ctx.moveTo(px(x) - 12, py(y));
      ctx.lineTo(px(x) + 12, py(y));
      ctx.moveTo(px(x), py(y) - 12);
      ctx.lineTo(px(x), py(y) + 12);
      ctx.stroke();
    }
  }
}

/** How much larger than on a desk things are to be: the page's own text size, over 16 px. */
export function zoom() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
}

/** The geometry moved down until what lies above the start is on the canvas too. */
function withHeadroom(geometry, { walls, pegs }) {
  const tops = [...walls.flatMap(({ y1, y2 }) => [y1, y2]), ...pegs.map(({ y, radius }) => y - radius)];
  const more = Math.max(0, HEADROOM - geometry.py(Math.min(Number.POSITIVE_INFINITY, ...tops)));
  return {
    ...geometry,
    height: Math.round(geometry.height + more),
    binTop: geometry.binTop + more,
    dropY: geometry.dropY + more,
    aimBottom: geometry.aimBottom + more,
    py: (y) => geometry.py(y) + more,
  };
}
