// Where balls have spent their time: a grid of fixed size, whatever falls over it. Pure.

import { poseBetween } from "../../model/motion/interpolate.js";

/** @import { Keyframe, Law } from "../../model/motion/interpolate.js" */

const CELLS = 240_000; // about a megabyte; half a centimetre to two on the usual boards
const STEP = 1 / 300; // s between samples: closer than a cell at the speeds of a board
const USUAL_SPEED = 2; // m/s: a ball this fast that crosses a cell adds one to it

/** @typedef {{left: number, right: number, top: number, bottom: number}} Field metres */

/** Counts over a field. */
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
    /** Rows touched since they were last read, as a range. */
    this.firstRow = this.height;
    this.lastRow = -1;
  }

  /**
   * Adds the stretch between two keyframes of a path, by the time it took.
   * @param {Keyframe} a
   * @param {Keyframe} b
   * @param {Law} law
   */
  follow(a, b, law) {
    const count = Math.max(1, Math.ceil((b.t - a.t) / STEP));
    const weight = (((b.t - a.t) / count) * USUAL_SPEED) / this.cell;
    for (let i = 0; i < count; i += 1) {
      poseBetween(a, b, a.t + ((i + 0.5) / count) * (b.t - a.t), law, pose);
      this.add(pose.x, pose.y, weight);
    }
  }

  /**
   * Spreads a weight over the four cells around a place, metres.
   * @param {number} x
   * @param {number} y
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

const pose = { x: 0, y: 0, angle: 0 };
