// A grid of the time that balls have spent in each place; its size does not grow with the number of balls. Pure.

import { poseBetween } from "../../model/motion/interpolate.js";

/** @import { Keyframe, Law } from "../../model/motion/interpolate.js" */

const CELLS = 240_000; // about a megabyte; cells of 0.5 to 2 cm on the usual boards
const STEP = 1 / 300; // s between samples: a ball moves less than a cell
const USUAL_SPEED = 2; // m/s: a ball of this speed that crosses a cell adds 1 to it

/** @typedef {{left: number, right: number, top: number, bottom: number}} Field m */

/** The grid over a field. */
export class Density {
  most = 0;

  /** @param {Field} field */
  constructor(field) {
    this.field = field;
    const across = field.right - field.left;
    const down = field.bottom - field.top;
    this.width = Math.max(1, Math.round(Math.sqrt((CELLS * across) / down)));
    this.height = Math.max(1, Math.round((this.width * down) / across));
    this.cell = across / this.width;
    this.cells = new Float32Array(this.width * this.height);
    /** The range of rows changed since they were last painted. */
    this.firstRow = this.height;
    this.lastRow = -1;
  }

  /**
   * Adds the part of a path between two keyframes, weighted by its duration.
   * @param {Keyframe} a
   * @param {Keyframe} b
   * @param {Law} law
   */
  follow(a, b, law) {
    const count = Math.max(1, Math.ceil((b.t - a.t) / STEP));
    const weight = (((b.t - a.t) / count) * USUAL_SPEED) / this.cell;
    for (let i = 0; i < count; i += 1) {
      const { x, y } = poseBetween(a, b, a.t + ((i + 0.5) / count) * (b.t - a.t), law);
      this.add(x, y, weight);
    }
  }

  /**
   * Spreads a weight over the four cells around a point.
   * @param {number} x m
   * @param {number} y m
   * @param {number} weight
   */
  add(x, y, weight) {
    const { field, cell, width, height } = this;
    const across = (x - field.left) / cell - 0.5;
    const down = (y - field.top) / cell - 0.5;
    const column = Math.floor(across);
    const row = Math.floor(down);
    if (!(column >= 0 && row >= 0 && column < width - 1 && row < height - 1)) return;
    const right = across - column;
    const below = down - row;
    const at = row * width + column;
    this.#put(at, weight * (1 - right) * (1 - below));
    this.#put(at + 1, weight * right * (1 - below));
    this.#put(at + width, weight * (1 - right) * below);
    this.#put(at + width + 1, weight * right * below);
    this.firstRow = Math.min(this.firstRow, row);
    this.lastRow = Math.max(this.lastRow, row + 1);
  }

  /** @param {number} at @param {number} weight */
  #put(at, weight) {
    this.cells[at] += weight;
    if (this.cells[at] > this.most) this.most = this.cells[at];
  }
}
