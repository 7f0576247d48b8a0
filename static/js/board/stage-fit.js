// Computes the largest size of a board that fits both the width and the height of its stage.

import { parentOf } from "../util/dom.js";

const STEPS = 24; // of bisection; the last one is far below a pixel

/**
 * @param {{width: number, height: number}} room CSS pixels
 * @param {(width: number) => number} heightOf the height of a picture by its width; must not decrease
 * @returns {number} the largest whole width that fits, CSS pixels
 */
export function widest({ width, height }, heightOf) {
  if (heightOf(width) <= height) return Math.floor(width);
  let [fits, breaks] = [0, width];
  for (let step = 0; step < STEPS; step += 1) {
    const middle = (fits + breaks) / 2;
    if (heightOf(middle) <= height) fits = middle;
    else breaks = middle;
  }
  return Math.floor(fits);
}

/** Fits a board's box to its stage; without a stage the box has the width of its parent. */
export class StageFit {
  #height = 0; // of the stage, CSS pixels

  /** @param {HTMLElement} box @param {() => void} onResize */
  constructor(box, onResize) {
    this.box = box;
    this.stage = /** @type {HTMLElement | null} */ (box.closest(".stage"));
    new ResizeObserver(onResize).observe(this.stage ?? box);
  }

  /**
   * Makes the box as large as possible.
   * @param {(width: number) => number} heightOf of the board at a width
   * @returns {number} its width, CSS pixels; 0 while the stage is hidden
   */
  fit(heightOf) {
    if (!this.stage) return this.box.clientWidth;
    const { clientWidth, clientHeight: height } = this.stage;
    const width = clientWidth - 2 * parseFloat(getComputedStyle(this.stage).paddingLeft);
    if (width <= 0 || !height) return 0;
    this.#height = height;
    const fitting = Math.max(1, widest({ width, height }, heightOf));
    this.box.style.width = `${fitting}px`;
    parentOf(this.stage).style.setProperty("--board-width", `${fitting}px`); // for the tray below
    return fitting;
  }

  /**
   * Aligns the stage's sunburst with the board's.
   * @param {number} height of the board @param {number} dropY the middle of the board's sunburst, CSS pixels
   */
  shine(height, dropY) {
    if (!this.stage) return;
    const top = (this.#height - height) / 2;
    this.stage.style.setProperty("--ray-y", `${Math.round(top + dropY)}px`);
  }
}

/**
 * Gives the style sheet the board's proportions, so that cabinet and desk fit the window.
 * @param {number} ratio width over height, without the headroom
 */
export function announceShape(ratio) {
  document.documentElement.style.setProperty("--board-ratio", ratio.toFixed(4));
}
