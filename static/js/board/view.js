// A board on two canvases: one for what never moves, one for each scene.

import { boardWords, placeOf } from "../model/worlds.js";
import { ALL_GROUNDS, paintField, paintFront } from "../paint/board.js";
import { layOut, ratioOf } from "../paint/geometry.js";
import { t } from "../texts/text.js";
import { contextOf } from "../util/canvas.js";
import { byId, parentOf } from "../util/dom.js";
import { multiplier } from "../util/format.js";
import { nextFrame } from "../util/frame-loop.js";
import { ScenePainter } from "./scene-painter.js";
import { announceShape, StageFit } from "./stage-fit.js";

/** @import { Board } from "../model/board.js" */
/** @import { Scene } from "../model/scene.js" */
/** @import { Grounds, Sheet } from "../paint/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Overlay } from "./scene-painter.js" */
/** @import { Theme } from "../paint/theme.js" */

/**
 * Draws a board and the scenes on it. `onLayout(geometry)` is called in the next frame, and when size or colours have
 * changed.
 */
export class BoardView {
  /** @type {Geometry | null} */
  geometry = null;
  /** @type {{board: Board, slots: number[]} | null} */
  #shown = null;
  /** @type {ScenePainter | null} */
  #painter = null;
  #density = 0;
  /** How many boards were set since the last one was painted. */
  #fresh = 0;

  /**
   * @param {Theme} theme
   * @param {(geometry: Geometry) => void} onLayout
   * @param {Grounds} [grounds] which backdrops to paint
   */
  constructor(theme, onLayout, grounds = ALL_GROUNDS) {
    this.still = byId("board-still", HTMLCanvasElement);
    this.box = parentOf(this.still);
    this.moving = byId("board-moving", HTMLCanvasElement);
    this.theme = theme;
    this.onLayout = onLayout;
    this.grounds = grounds;
    this.fit = new StageFit(this.box, () => this.relayout());
    this.#followDensity();
    theme.onChange(() => {
      this.repaint();
      if (this.geometry) onLayout(this.geometry);
    });
  }

  /** @returns {Board | null} */
  get board() {
    return this.#shown?.board ?? null;
  }

  /** @param {Board} board @param {number[]} [slots] */
  setBoard(board, slots = board.drop.slots ?? []) {
    this.geometry = null;
    this.#painter = null;
    announceShape(ratioOf(board));
    this.moving.setAttribute("aria-label", describeBoard(board));
    this.theme.enter(placeOf(board.name));
    this.#shown = { board, slots };
    // With all its backdrops the board is opaque. The browser then need not blend it with the page below.
    const { around, plate } = this.grounds;
    this.still.getContext("2d", { alpha: !around || !plate });
    void this.#open(board);
  }

  /** Lays the page out in one frame, and paints field and front in the next two: together they are a long task. @param {Board} board */
  async #open(board) {
    const turn = (this.#fresh += 1);
    await nextFrame();
    this.#fit(board);
    await nextFrame();
    if (turn !== this.#fresh) return;
    if (this.#resize()) this.#paint(paintField);
    await nextFrame();
    if (turn !== this.#fresh) return;
    this.#fresh = 0;
    if (this.#resize()) this.repaint();
    else if (!this.#painter) this.#finish();
    if (this.geometry) this.onLayout(this.geometry);
  }

  /** @param {Board} board @returns {Geometry | null} how it fits into its box; null while that is hidden */
  #fit(board) {
    const width = this.fit.fit((wide) => layOut(board, wide).height);
    if (!width) return null;
    const geometry = layOut(board, width);
    for (const canvas of [this.still, this.moving]) canvas.style.height = `${geometry.height}px`;
    return geometry;
  }

  /** Fits the canvases to their box and the display, and repaints them, if one of these has changed. */
  relayout() {
    if (this.#fresh || !this.#resize()) return;
    this.repaint();
    if (this.geometry) this.onLayout(this.geometry);
  }

  /** @returns {boolean} whether the canvases have changed their size, and are empty now */
  #resize() {
    const geometry = this.#shown && this.#fit(this.#shown.board);
    const density = window.devicePixelRatio || 1;
    if (!geometry) return false;
    this.fit.shine(geometry.height, geometry.dropY);
    if (geometry.width === this.geometry?.width && density === this.#density) return false;
    this.#density = density;
    this.geometry = geometry;
    for (const canvas of [this.still, this.moving]) fit(canvas, geometry, density);
    return true;
  }

  /** Repaints the still canvas after a change of colours or size. */
  repaint() {
    this.#paint(paintField);
    this.#finish();
  }

  /** Paints bins and rails; scenes can be drawn from then on. */
  #finish() {
    const { geometry, still, theme, board } = this;
    if (!geometry || !board) return;
    this.#paint(paintFront);
    this.#painter = new ScenePainter({ still, board, geometry, density: this.#density }, theme);
  }

  /** @param {(sheet: Sheet, slots: number[], grounds: Grounds) => void} part */
  #paint(part) {
    const { geometry, still, theme } = this;
    if (!geometry || !this.#shown) return;
    const { board, slots } = this.#shown;
    part({ ctx: contextOf(still), geometry, board, look: theme }, slots, this.grounds);
  }

  /** @param {Scene} scene @param {Overlay} [paintOver] */
  draw(scene, paintOver = () => {}) {
    this.#painter?.draw(contextOf(this.moving), scene, paintOver);
  }

  /** @param {MouseEvent} event @returns {{x: number, y: number, above: boolean} | null} */
  aimOf(event) {
    // A new board can be clicked a frame before it is painted.
    const geometry = this.geometry ?? (this.#shown && this.#fit(this.#shown.board));
    if (!geometry) return null;
    const box = this.still.getBoundingClientRect();
    return {
      x: geometry.x(event.clientX - box.left),
      y: geometry.y(event.clientY - box.top),
      above: event.clientY - box.top <= geometry.aimBottom,
    };
  }

  /** Follows the pixel ratio, which another screen or zoom changes without changing the box. */
  #followDensity() {
    const query = window.matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    query.addEventListener("change", () => {
      this.relayout();
      this.#followDensity();
    }, { once: true });
  }
}

/** @param {HTMLCanvasElement} canvas @param {Geometry} geometry @param {number} density */
function fit(canvas, { width, height }, density) {
  canvas.width = Math.round(width * density);
  canvas.height = Math.round(height * density);
  contextOf(canvas).setTransform(density, 0, 0, density, 0, 0);
}

/** @param {Board} board @returns {string} for screen readers */
function describeBoard(board) {
  const { multipliers } = board.bins;
  const rows = new Set(board.pegs.map((peg) => peg.y.toFixed(6))).size;
  const middle = multipliers[Math.floor(multipliers.length / 2)];
  const [edge, inner] = [multipliers[0], middle].map(multiplier);
  return t("page.board-picture", { name: boardWords(board.name), rows, bins: multipliers.length, edge, middle: inner });
}
