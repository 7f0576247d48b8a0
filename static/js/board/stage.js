// A board with marks, on four canvases: the board, marks under the balls, the balls, marks over them.

import { fitted } from "../util/canvas.js";
import { byId } from "../util/dom.js";
import { BoardView } from "./view.js";

/** @import { Scene } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */

/** @typedef {{ctx: CanvasRenderingContext2D, geometry: Geometry}} Layer an empty canvas to paint on */

/** The canvases of a page about drops. */
export class Stage extends BoardView {
  under = byId("board-marks", HTMLCanvasElement);
  over = byId("board-arrows", HTMLCanvasElement);

  /**
   * @param {Scene} scene
   * @param {(layer: Layer) => void} paintUnder paints under the balls
   * @param {(layer: Layer) => void} [paintOver] paints over the balls
   */
  show(scene, paintUnder, paintOver = () => {}) {
    const { geometry } = this;
    if (!geometry) return;
    paintUnder({ ctx: fitted(this.under, geometry), geometry });
    this.draw(scene);
    paintOver({ ctx: fitted(this.over, geometry), geometry });
  }
}
