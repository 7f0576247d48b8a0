// Paints what never moves: plate, rails, pegs, bins. Called on resize and theme change only.

import { sidesOf, startSpan } from "../model/board.js";
import { disc } from "../util/canvas.js";
import { tight } from "../util/format.js";
import { GROUNDS, SURROUNDINGS } from "./ground.js";
import { paintPeg } from "./peg.js";

/** @import { Board, Wall } from "../model/board.js" */
/** @import { Geometry } from "./geometry.js" */
/** @import { Look, Palette, PayoutColour, PegShape, RailShape } from "./theme.js" */

export const LABEL_FONT = '"DIN Alternate", Bahnschrift, "Liberation Sans Narrow", "Arial Narrow", sans-serif';
const FILLED = 0.9; // of a pocket by the widest number

/**
 * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {number[]} slots
 * @param {Look} look
 */
export function paintBoard(ctx, geometry, board, slots, look) {
  const { palette: colours, shapes } = look;
  paintPlate(ctx, geometry, board, look);
  paintHopper(ctx, geometry, board, slots, colours);
  paintPegs(ctx, geometry, board, colours, shapes.peg);
  board.bins.multipliers.forEach((score, bin) => {
    paintBin(ctx, geometry, board, bin, look.payout(score));
  });
  paintRails(ctx, geometry, board, colours, shapes.rail);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {Look} look
 */
function paintPlate(ctx, geometry, board, { palette: colours, shapes: { rays }, ground, grounds }) {
  const { px, dropY, width, height } = geometry;
  const place = { x: px(board.drop.x), y: dropY, width, height, colours, rays, grounds };
  ctx.fillStyle = colours.shoulder;
  ctx.fillRect(0, 0, width, height);
  SURROUNDINGS[ground](ctx, place);
  if (ground !== "rays") fadeSides(ctx, geometry, colours.shoulder);
  ctx.save();
  clipToField(ctx, geometry, board);
  const enamel = ctx.createLinearGradient(0, 0, 0, height);
  enamel.addColorStop(0, colours.board);
  enamel.addColorStop(1, colours.boardDeep);
  ctx.fillStyle = enamel;
  ctx.fillRect(0, 0, width, height);
  GROUNDS[ground](ctx, place);
  ctx.restore();
}

/**
 * Beyond the picture's sides the page goes on in the colour of the shoulders.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {string} colour #rrggbb
 */
function fadeSides(ctx, { width, height }, colour) {
  const fade = ctx.createLinearGradient(0, 0, width, 0);
  for (const [at, alpha] of [[0, "ff"], [0.07, "00"], [0.93, "00"], [1, "ff"]]) {
    fade.addColorStop(Number(at), `${colour}${alpha}`);
  }
  ctx.fillStyle = fade;
  ctx.fillRect(0, 0, width, height);
}

/** @typedef {{x: number, y: number, width: number, height: number}} Box */

/**
 * The part between the walls at the left side and those at the right; all of it without them.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 */
function clipToField(ctx, { px, py, width, height }, board) {
  const sides = sidesOf(board);
  const left = chain(board.walls.filter((_, number) => sides[number] < 0));
  const right = chain(board.walls.filter((_, number) => sides[number] > 0));
  ctx.beginPath();
  if (left.length && right.length) {
    const outline = [...left, ...right.reverse()].map(({ x, y }) => ({ x: px(x), y: py(y) }));
    ctx.moveTo(outline[0].x, 0);
    for (const { x, y } of outline.slice(0, left.length)) ctx.lineTo(x, y);
    ctx.lineTo(outline[left.length - 1].x, height);
    ctx.lineTo(outline[left.length].x, height);
    for (const { x, y } of outline.slice(left.length)) ctx.lineTo(x, y);
    ctx.lineTo(outline[outline.length - 1].x, 0);
  } else {
    ctx.rect(0, 0, width, height);
  }
  ctx.clip();
}

/** The ends of some walls from top to bottom. @param {Wall[]} walls */
function chain(walls) {
  const ends = walls.flatMap(({ x1, y1, x2, y2 }) => [{ x: x1, y: y1 }, { x: x2, y: y2 }]);
  return ends.sort((one, two) => one.y - two.y);
}

/**
 * The slide along which a ball may start, or the numbered slots.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {number[]} slots
 * @param {Palette} colours
 */
function paintHopper(ctx, { px, dropY, scale }, board, slots, colours) {
  const radius = Math.max(board.ball.radius * scale, 5);
  ctx.lineCap = "round";
  if (slots.length) {
    ctx.font = `700 ${Math.round(Math.max(12, Math.min(20, 0.2 * scale)))}px ${LABEL_FONT}`;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    slots.forEach((slot, index) => {
      ctx.fillStyle = colours.railShade;
      disc(ctx, px(slot), dropY, radius + 3);
      ctx.fillStyle = colours.rail;
      ctx.fillText(String(index + 1), px(slot), dropY - radius - 16);
    });
    return;
  }
  const { x } = board.drop;
  const span = startSpan(board.drop);
  stroke(ctx, px(x - span), dropY, px(x + span), dropY, 2 * radius + 6, colours.railShade);
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {Palette} colours
 * @param {PegShape} shape
 */
function paintPegs(ctx, { px, py, scale }, board, colours, shape) {
  const { across, down, alpha } = shape.shadow;
  ctx.globalAlpha = alpha;
  ctx.fillStyle = colours.shadow;
  for (const peg of board.pegs) {
    const r = peg.radius * scale;
    disc(ctx, px(peg.x) + across * r, py(peg.y) + down * r, r);
  }
  ctx.globalAlpha = 1;
  for (const peg of board.pegs) {
    paintPeg(ctx, { x: px(peg.x), y: py(peg.y), r: peg.radius * scale }, colours, shape);
  }
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {Palette} colours
 * @param {RailShape} railShape
 */
function paintRails(ctx, { px, py, scale }, board, colours, { metres, least, shade }) {
  const width = Math.max(least, metres * scale);
  ctx.lineCap = "round";
  const sides = sidesOf(board);
  /** @param {string} colour @param {number} right @param {number} down CSS pixels */
  const rails = (colour, right, down) => board.walls.forEach((wall, number) => {
    // A wall has no thickness; at a side its rail lies outside, so that balls touch its inner edge.
    const across = sides[number] * (width / 2) + right;
    stroke(ctx, px(wall.x1) + across, py(wall.y1) + down, px(wall.x2) + across, py(wall.y2) + down, width, colour);
  });
  rails(colours.railShade, shade[0], shade[1]); // all of them first: none lies on another's rail
  rails(colours.rail, 0, 0);
}

/**
 * One pocket with its multiplier.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {number} bin
 * @param {PayoutColour} colour
 */
function paintBin(ctx, geometry, board, bin, colour) {
  const { x, y, width, height } = binBox(geometry, board, bin);
  if (width <= 0) return; // a canvas that is not laid out yet, or a sliver of one
  ctx.fillStyle = colour.fill;
  roundedBox(ctx, x, y, width, height, Math.min(8, 0.22 * width));
  paintLabel(ctx, geometry, board, bin, colour.ink, { x, y, width, height });
}

/** @param {Geometry} geometry @param {Board} board @param {number} bin @returns {Box} CSS pixels */
export function binBox({ px, binTop, binHeight }, board, bin) {
  const from = px(board.bins.edges[bin]);
  const to = px(board.bins.edges[bin + 1]);
  const gap = Math.max(1, Math.min(3, 0.06 * (to - from)));
  return { x: from + gap, y: binTop + 2, width: to - from - 2 * gap, height: binHeight - 4 };
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {Geometry} geometry
 * @param {Board} board
 * @param {number} bin
 * @param {string} ink
 * @param {Box} box
 */
function paintLabel(ctx, geometry, board, bin, ink, { x, y, width, height }) {
  const texts = board.bins.multipliers.map(tight);
  const longest = Math.max(...texts.map((text) => text.length));
  const narrowest = Math.min(...texts.map((_, other) => binBox(geometry, board, other).width));
  // Narrow pockets carry their number upright, as on a ruler, rather than too small to read.
  const upright = narrowest / longest < 7.5;
  const most = upright
    ? Math.min(0.8 * narrowest, (1.6 * height) / longest)
    : Math.min((1.75 * width) / longest, (2.1 * narrowest) / longest, 0.52 * height);
  ctx.font = `700 ${most.toFixed(1)}px ${LABEL_FONT}`;
  // Not every system has a narrow font: what its own leaves too little room for is smaller, and all the others with it.
  const fits = texts.map((text, other) => {
    const room = upright ? height : binBox(geometry, board, other).width;
    return (FILLED * room) / ctx.measureText(text).width;
  });
  const size = most * Math.min(1, ...fits);
  ctx.save();
  ctx.translate(x + width / 2, y + height / 2);
  if (upright) ctx.rotate(-Math.PI / 2);
  ctx.font = `700 ${size.toFixed(1)}px ${LABEL_FONT}`;
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillStyle = ink;
  ctx.fillText(texts[bin], 0, 0.06 * size);
  ctx.restore();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x
 * @param {number} y
 * @param {number} width
 * @param {number} height
 * @param {number} radius
 */
function roundedBox(ctx, x, y, width, height, radius) {
  ctx.beginPath();
  ctx.roundRect(x, y, width, height, radius);
  ctx.fill();
}

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {number} x1
 * @param {number} y1
 * @param {number} x2
 * @param {number} y2
 * @param {number} width
 * @param {string} colour
 */
function stroke(ctx, x1, y1, x2, y2, width, colour) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  ctx.stroke();
}
