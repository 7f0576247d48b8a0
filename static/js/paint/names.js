// Name plates of balls: each is drawn once; each frame only copies it. Long names take two lines.

import { sheetContext } from "../util/canvas.js";
import { LABEL_FONT } from "./board.js";

const MOST = 256; // names kept; with more in flight, some are drawn again
const INK = "#ffffff"; // with the dark rim it is readable on any board and any backdrop
const RIM = "#14181d";
const LONG = 14; // letters on a line
const LINE = 1.1; // of the letters' size
const DOTS = "…";
/** @type {Intl.Segmenter | null} made when first needed, as loading it takes long */
let letters = null;

/** @param {string} text @returns {string[]} what a reader takes for letters, such as an emoji of several parts */
function lettersOf(text) {
  letters ??= new Intl.Segmenter();
  return [...letters.segment(text)].map(({ segment }) => segment);
}

/** @param {string} name @returns {string[]} on one line or two, shortened at a word if it is longer */
export function linesOf(name) {
  const lines = [""];
  for (const word of name.split(" ")) {
    const line = lines[lines.length - 1];
    const longer = line === "" ? word : `${line} ${word}`;
    if (lettersOf(longer).length <= LONG) lines[lines.length - 1] = longer;
    else if (line === "") lines[lines.length - 1] = cut(word);
    else if (lines.length === 1) lines.push(lettersOf(word).length <= LONG ? word : cut(word));
    else return [lines[0], `${line}${DOTS}`];
  }
  return lines;
}

/** @param {string} word */
const cut = (word) => lettersOf(word).slice(0, LONG - 1).join("") + DOTS;

/** @typedef {{sheet: ImageBitmap, width: number, height: number}} Plate CSS pixels */

/** @typedef {{side: number, box: {x: number, y: number, width: number, height: number}, sheet: ImageBitmap}} Placed */

/**
 * Places each name above, below, right or left of its ball, where no other name is. Without a free place it is left out.
 * A name stays on its side as long as it can.
 * @param {(Plate & {ball: number | undefined, x: number, y: number})[]} plates with their balls' middles; the first ones
 *   choose first
 * @param {{width: number, height: number, reach: number}} picture reach: from a ball's middle to its name
 * @param {Map<number | undefined, Placed>} before in the last picture, by ball
 * @returns {Map<number | undefined, Placed>}
 */
export function placeNames(plates, { width: wide, height: high, reach }, before) {
  /** @type {Map<number | undefined, Placed>} */
  const placed = new Map();
  for (const { ball, sheet, width, height, x, y } of plates) {
    const boxes = [
      [x - width / 2, y - reach - height], [x - width / 2, y + reach], [x + reach, y - height / 2],
      [x - reach - width, y - height / 2],
    ].map(([left, top]) => ({
      x: Math.max(0, Math.min(wide - width, left)), y: Math.max(0, Math.min(high - height, top)), width, height,
    }));
    const others = [...placed.values()];
    const side = [before.get(ball)?.side ?? 0, 0, 1, 2, 3].find((each) =>
      others.every(({ box }) => !overlap(box, boxes[each])));
    if (side !== undefined) placed.set(ball, { side, box: boxes[side], sheet });
  }
  return placed;
}

/** @param {Placed["box"]} one @param {Placed["box"]} two */
function overlap(one, two) {
  return one.x < two.x + two.width && two.x < one.x + one.width && one.y < two.y + two.height
    && two.y < one.y + one.height;
}

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
    const lines = linesOf(name);
    const width = Math.ceil(Math.max(...lines.map((line) => measure.measureText(line).width)) + size);
    const height = Math.ceil((0.5 + LINE * lines.length) * size);
    const ctx = sheetContext(Math.ceil(width * density), Math.ceil(height * density));
    ctx.setTransform(density, 0, 0, density, 0, 0);
    Object.assign(ctx, { font, textAlign: "center", textBaseline: "middle", lineJoin: "round" });
    ctx.lineWidth = Math.max(2, 0.22 * size);
    ctx.strokeStyle = RIM;
    ctx.fillStyle = INK;
    lines.forEach((line, i) => {
      const y = height / 2 + (i - (lines.length - 1) / 2) * LINE * size;
      ctx.strokeText(line, width / 2, y);
      ctx.fillText(line, width / 2, y);
    });
    return { sheet: ctx.canvas.transferToImageBitmap(), width, height };
  }
}
