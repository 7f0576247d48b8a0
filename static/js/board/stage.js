// A board with marks drawn on it: what never moves, then paths, then the balls, then arrows.

import { ratioOf } from "../paint/geometry.js";
import { fitted } from "../util/canvas.js";
import { byId } from "../util/dom.js";
import { describeBoard } from "./alternative-text.js";
import { announceShape } from "./shape.js";
import { BoardView } from "./view.js";

/** @import { Board } from "../model/board.js" */
/** @import { Scene } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */

/** @typedef {{ctx: CanvasRenderingContext2D, geometry: Geometry}} Layer cleared, to be painted on */

/** The canvases of a page that looks at drops. `onLayout` tells that the size changed. */
export class Stage {
  /** @param {Theme} theme @param {() => void} onLayout */
  constructor(theme, onLayout) {
    this.under = byId("board-marks", HTMLCanvasElement);
    this.over = byId("board-arrows", HTMLCanvasElement);
    const canvases = {
      still: byId("board-still", HTMLCanvasElement),
      moving: byId("board-moving", HTMLCanvasElement),
    };
    this.view = new BoardView(canvases, theme, () => onLayout());
    theme.onChange(() => {
      this.view.repaint();
      onLayout();
    });
  }

  get geometry() {
    return this.view.geometry;
  }

  /** @param {Board} board */
  setBoard(board) {
    announceShape(ratioOf(board));
    this.view.setBoard(board, board.drop.slots ?? []);
    byId("board-moving").setAttribute("aria-label", describeBoard(board));
  }

  /**
   * @param {Scene} scene
   * @param {(layer: Layer) => void} paintUnder what lies under the balls
   * @param {(layer: Layer) => void} [paintOver] what lies over them
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
