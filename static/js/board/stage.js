// A board with marks, on four canvases: the board, marks under the balls, the balls, marks over them.

import { fitted } from "../util/canvas.js";
import { byId } from "../util/dom.js";
import { BoardView } from "./view.js";

/** @import { Board } from "../model/board.js" */
/** @import { Scene } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */

/** @typedef {{ctx: CanvasRenderingContext2D, geometry: Geometry}} Layer an empty canvas to paint on */

/** The canvases of a page about drops. `onLayout` is called when size or colours have changed. */
export class Stage {
  /** @param {Theme} theme @param {() => void} onLayout */
  constructor(theme, onLayout) {
    this.under = byId("board-marks", HTMLCanvasElement);
    this.over = byId("board-arrows", HTMLCanvasElement);
    this.view = new BoardView(theme, onLayout);
  }

  get geometry() {
    return this.view.geometry;
  }

  /** @param {Board} board */
  setBoard(board) {
    this.view.setBoard(board, board.drop.slots ?? []);
  }

  /**
   * @param {Scene} scene
   * @param {(layer: Layer) => void} paintUnder paints under the balls
   * @param {(layer: Layer) => void} [paintOver] paints over the balls
   */
  draw(scene, paintUnder, paintOver = () => {}) {
    const { geometry } = this;
    if (!geometry) return;
    paintUnder({ ctx: fitted(this.under, geometry), geometry });
    this.view.draw(scene);
    paintOver({ ctx: fitted(this.over, geometry), geometry });
  }

  /** @param {MouseEvent} event @returns {{x: number, y: number} | null} metres */
  placeOf(event) {
    if (!this.geometry) return null;
    const box = this.view.still.getBoundingClientRect();
    const { x, py, scale } = this.geometry;
    return { x: x(event.clientX - box.left), y: (event.clientY - box.top - py(0)) / scale };
  }
}
