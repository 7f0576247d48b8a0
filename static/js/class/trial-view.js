// A canvas with one trial of the lesson: its board, its balls and its histogram.

import { contextOf, fitted } from "../util/canvas.js";
import { byId } from "../util/dom.js";
import { binAt, layOut, paintTrial } from "./paint.js";
import { theoryOf } from "./statistics.js";
import { binomialChances } from "../model/statistics.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Geometry } from "./paint.js" */
/** @import { Trial } from "./trial.js" */

/** Draws a trial; `onResize` is called when its size has changed. */
export class TrialView {
  /** @type {Geometry | null} */
  geometry = null;
  #size = { width: 0, height: 0, font: 16 };

  /** @param {string} id of the canvas @param {Theme} theme @param {() => void} onResize */
  constructor(id, theme, onResize) {
    this.canvas = byId(id, HTMLCanvasElement);
    this.theme = theme;
    new ResizeObserver(() => {
      const { clientWidth: width, clientHeight: height } = this.canvas;
      const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
      this.#size = { width, height, font: Math.max(0.7 * rem, Math.min(1.1 * rem, width / 40)) };
      onResize();
    }).observe(this.canvas);
  }

  /**
   * @param {Trial} trial @param {number} now ms
   * @param {{all: boolean, guess: number[] | null, secret: boolean, cursor: number | null, plain?: boolean}} shown plain:
   *   without theory
   */
  draw(trial, now, { all, guess, secret, cursor, plain }) {
    const { board, setting: { rows, p } } = trial;
    if (this.#size.width === 0) return;
    this.geometry = layOut(board, this.#size);
    const { counts } = trial.over(all);
    const n = counts.reduce((total, count) => total + count, 0);
    const twins = trial.pair.map((ball) => ({ ...ball, at: timeOf(ball, now, trial.calm) }));
    const falling = [...trial.balls.map((ball) => ({ ...ball, at: timeOf(ball, now, false) })), ...twins];
    fitted(this.canvas, this.#size);
    paintTrial(contextOf(this.canvas), board, this.geometry, this.theme.palette, {
      balls: falling.map(({ fall, at, other }) => ({ ...fall.placeAt(at), other })),
      paths: twins.map(({ fall, at }) => fall.pathTo(at)),
      counts, due: binomialChances(rows, p).map((chance) => chance * n), law: plain ? null : theoryOf(rows, p, n),
      guess, secret, cursor,
    });
  }

  /** @param {PointerEvent} event @returns {{bin: number, height: number} | null} height: 0 … 100, in the histogram */
  pointed({ clientX, clientY }) {
    if (!this.geometry) return null;
    const { left, top } = this.canvas.getBoundingClientRect();
    const { top: high, bottom } = this.geometry;
    const bin = binAt(this.geometry, clientX - left);
    const height = Math.round((100 * (bottom - (clientY - top))) / (bottom - high));
    return bin < 0 ? null : { bin, height: Math.max(0, Math.min(100, height)) };
  }
}

/** @param {{fall: {end: number}, since: number}} ball @param {number} now ms @param {boolean} calm @returns {number} s since its start */
function timeOf({ fall, since }, now, calm) {
  return calm ? fall.end : Math.min(fall.end, Math.max(0, (now - since) / 1000));
}
