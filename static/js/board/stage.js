// A board with marks drawn on it: what never moves, then paths, then the balls, then arrows.

import { BoardView } from "./view.js";
import { byId } from "../util/dom.js";
import { announceShape } from "../paint/geometry.js";
import { describeBoard } from "./alternative-text.js";

/** @typedef {(ctx: CanvasRenderingContext2D, geometry: import("../paint/geometry.js").Geometry) => void} Paint */

/** The canvases of a page that looks at drops. `onLayout` tells that the size changed. */
export class Stage {
  /** @param {import("../paint/theme.js").Theme} theme @param {() => void} onLayout */
  constructor(theme, onLayout) {
    this.under = byId("board-marks");
    this.over = byId("board-arrows");
    const canvases = { still: byId("board-still"), moving: byId("board-moving") };
    this.view = new BoardView(canvases, theme, () => onLayout());
    theme.onChange(() => {
      this.view.repaint();
      onLayout();
    });
  }

  get geometry() {
    return this.view.geometry;
  }

  /** @param {any} board */
  setBoard(board) {
    announceShape(board);
    this.view.setBoard(board, board.drop.slots ?? []);
    byId("board-moving").setAttribute("aria-label", describeBoard(board));
  }

  /**
   * @param {import("./view.js").Scene} scene
   * @param {Paint} paintUnder what lies under the balls
   * @param {Paint} [paintOver] what lies over them
   */
  draw(scene, paintUnder, paintOver = () => {}) {
    if (!this.geometry) return;
    paintUnder(fitted(this.under, this.geometry), this.geometry);
    this.view.draw(scene);
    paintOver(fitted(this.over, this.geometry), this.geometry);
  }

  /** @param {PointerEvent} event @returns {{x: number, y: number} | null} metres */
  placeOf(event) {
    if (!this.geometry) return null;
    const box = this.view.still.getBoundingClientRect();
    const { x, py, scale } = this.geometry;
    return { x: x(event.clientX - box.left), y: (event.clientY - box.top - py(0)) / scale };
  }
}

/**
 * A canvas cleared, as large as the geometry says, scaled to CSS pixels.
 * @param {HTMLCanvasElement} canvas
 * @param {{width: number, height: number}} size CSS pixels
 * @returns {CanvasRenderingContext2D}
 */
export function fitted(canvas, { width, height }) {
  const density = window.devicePixelRatio || 1;
  const [across, down] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width !== across || canvas.height !== down) {
    canvas.width = across;
    canvas.height = down;
  }
  const ctx = canvas.getContext("2d");
  ctx.setTransform(density, 0, 0, density, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return ctx;
}
