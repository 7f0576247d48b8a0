// Fits labels into bins: horizontal or turned by a quarter, on up to three lines, cut if too long.

import { labelOf } from "../model/board.js";
import { multiplier } from "../util/format.js";

/** @import { Board, Label } from "../model/board.js" */
/** @import { Box } from "./board.js" */
/** @import { PayoutColour } from "./theme.js" */

const LEGIBLE = 9; // smallest size of a label, CSS pixels
const LARGEST = 24;
const FILLED = 0.86; // of a bin, by its label
const LINES = 3;
const LINE_HEIGHT = 1.15; // of the letters' size
const DOTS = "…";

/** @typedef {{text: string, colours: Pick<PayoutColour, "fill" | "ink">}} Pocket text and colours of a bin */
/** @typedef {{lines: string[], size: number, along: boolean}} Lettering size: CSS pixels; along: turned by a quarter */
/** @typedef {(text: string) => number} WidthOf width of a text in letters of 1 CSS pixel */

/**
 * @param {Label | null} label
 * @param {PayoutColour} payout
 * @returns {Pocket["colours"]} the label's colour, by default the payout's
 */
export function coloursOf(label, payout) {
  const fill = label?.colour;
  return fill ? { fill, ink: inkOn(fill) } : payout;
}

/**
 * The prize of a landing: the label's text, by default the multiplier.
 * @param {Pick<Board, "bins"> | null} board
 * @param {number | null} bin
 * @param {number} score
 * @returns {string}
 */
export const prizeOf = (board, bin, score) => (board && labelOf(board, bin)?.text) ?? multiplier(score);

/** @param {string} colour #rrggbb @returns {string} black or white, whichever has more contrast */
export function inkOn(colour) {
  const [red, green, blue] = [1, 3, 5].map((at) => {
    const part = parseInt(colour.slice(at, at + 2), 16) / 255;
    return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.179 ? "#000000" : "#ffffff";
}

/**
 * Letters all labels horizontally or all turned, whichever makes the smallest letters larger.
 * @param {WidthOf} widthOf
 * @param {string[]} texts one for each box
 * @param {Box[]} boxes
 * @returns {Lettering[]}
 */
export function letteringOf(widthOf, texts, boxes) {
  const [across, along] = [false, true].map((turned) => texts.map((text, bin) => {
    const { width, height } = boxes[bin];
    const room = turned ? { long: height, deep: width } : { long: width, deep: height };
    return fitted(widthOf, text, { long: FILLED * room.long, deep: FILLED * room.deep }, turned);
  }));
  const least = (/** @type {Lettering[]} */ way) => Math.min(...way.map(({ size }) => size));
  return least(along) > least(across) ? along : across;
}

/**
 * @param {WidthOf} widthOf
 * @param {string} text
 * @param {{long: number, deep: number}} room along and across the lines, CSS pixels
 * @param {boolean} along
 * @returns {Lettering} the largest that fits
 */
function fitted(widthOf, text, room, along) {
  const found = { size: 0, lines: [text] };
  for (const lines of broken(text.split(" "), LINES)) {
    const size = Math.min(
      ...lines.map((line) => room.long / widthOf(line)), room.deep / (LINE_HEIGHT * lines.length),
    );
    if (size > found.size) Object.assign(found, { size, lines });
  }
  const least = Math.min(LEGIBLE, room.deep / LINE_HEIGHT);
  if (along && found.size < least) return { lines: [cut(widthOf, text, room.long / least)], size: least, along };
  return { lines: found.lines, size: Math.min(found.size, LARGEST), along };
}

/** @param {string[]} words @param {number} most @returns {string[][]} all ways to put them on at most that many lines */
function broken(words, most) {
  const ways = [[words.join(" ")]];
  if (most === 1) return ways;
  for (let first = 1; first < words.length; first += 1) {
    const line = words.slice(0, first).join(" ");
    ways.push(...broken(words.slice(first), most - 1).map((rest) => [line, ...rest]));
  }
  return ways;
}

/**
 * @param {WidthOf} widthOf
 * @param {string} text
 * @param {number} most of its width, in the same unit
 * @returns {string} the text, shortened if it is wider
 */
function cut(widthOf, text, most) {
  if (widthOf(text) <= most) return text;
  const letters = [...text];
  while (letters.length > 1 && widthOf(letters.join("") + DOTS) > most) letters.pop();
  return letters.join("").trimEnd() + DOTS;
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Pocket[]} pockets one for each box
 * @param {Box[]} boxes
 * @param {string} font its family
 */
export function paintPrizes(ctx, pockets, boxes, font) {
  ctx.font = `700 100px ${font}`;
  const widthOf = (/** @type {string} */ text) => ctx.measureText(text).width / 100;
  const letterings = letteringOf(widthOf, pockets.map(({ text }) => text), boxes);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  boxes.forEach(({ x, y, width, height }, bin) => {
    const { lines, size, along } = letterings[bin];
    ctx.save();
    ctx.translate(x + width / 2, y + height / 2);
    if (along) ctx.rotate(-Math.PI / 2);
    ctx.font = `700 ${size.toFixed(1)}px ${font}`;
    ctx.fillStyle = pockets[bin].colours.ink;
    lines.forEach((line, number) => {
      ctx.fillText(line, 0, (0.06 + (number - (lines.length - 1) / 2) * LINE_HEIGHT) * size);
    });
    ctx.restore();
  });
}
