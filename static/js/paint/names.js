// Name plates of balls: each is drawn once; each frame only copies it.

import { sheetContext } from "../util/canvas.js";
import { LABEL_FONT } from "./board.js";

const MOST = 256; // names kept; with more in flight, some are drawn again
const INK = "#ffffff"; // with the dark rim it is readable on any board and any backdrop
const RIM = "#14181d";

/** @typedef {{sheet: ImageBitmap, width: number, height: number}} Plate CSS pixels */

/** The plates for one size of letters and one screen density. */
export class NameBook {
  /** @type {Map<string, Plate>} */
  #plates = new Map();

  /** @param {number} size of the letters, CSS pixels @param {number} density */
  constructor(size, density) {
    this.size = size;
    this.density = density;
  }

  /** @param {string} name @returns {Plate} */
  of(name) {
    const made = this.#plates.get(name);
    if (made) return made;
    if (this.#plates.size === MOST) this.#plates.clear();
    const plate = this.#make(name);
    this.#plates.set(name, plate);
    return plate;
  }

  /** @param {string} name @returns {Plate} */
  #make(name) {
    const { size, density } = this;
    const font = `700 ${size}px ${LABEL_FONT}`;
    const measure = sheetContext(1, 1);
    measure.font = font;
    const width = Math.ceil(measure.measureText(name).width + size);
    const height = Math.ceil(1.6 * size);
    const ctx = sheetContext(Math.ceil(width * density), Math.ceil(height * density));
    ctx.setTransform(density, 0, 0, density, 0, 0);
    Object.assign(ctx, { font, textAlign: "center", textBaseline: "middle", lineJoin: "round" });
    ctx.lineWidth = Math.max(2, 0.22 * size);
    ctx.strokeStyle = RIM;
    ctx.strokeText(name, width / 2, height / 2);
    ctx.fillStyle = INK;
    ctx.fillText(name, width / 2, height / 2);
    return { sheet: ctx.canvas.transferToImageBitmap(), width, height };
  }
}
