// Paints the backdrops of boards: the print on the plate, and the scene around it. All measures are in
// theme.json; app/render/parts/ground.py paints the same for pictures.

import { disc, strokeLine } from "../util/canvas.js";

/** @import { Grounds, Palette, Planet } from "./theme.js" */

/**
 * @typedef {object} Place
 * @property {number} x where the rays begin: at the drop zone, CSS pixels
 * @property {number} y
 * @property {number} width of the picture, CSS pixels
 * @property {number} height
 * @property {Palette} colours
 * @property {number} rays number of wedges of the sunburst, of which every other one is printed
 * @property {Grounds} grounds
 *
 * @typedef {(ctx: CanvasRenderingContext2D, place: Place) => void} Paint
 */

const TURN = 2 * Math.PI;
const BENDS = 60; // straight pieces of a wave from side to side

/** The print on the plate, between the walls. @type {Record<string, Paint>} */
export const GROUNDS = {
  rays: (ctx, place) => {
    ctx.globalAlpha = 0.6;
    rays(ctx, place, place.colours.ray);
  },
  craters,
  dunes,
  bands,
  panes,
  plates,
  court,
};

/** The scene around the plate, beyond the walls. @type {Record<string, Paint>} */
export const SURROUNDINGS = {
  rays: (ctx, place) => rays(ctx, place, place.colours.shoulderRay),
  craters: (ctx, place) => sky(ctx, place, place.grounds.craters.around),
  dunes: (ctx, place) => sky(ctx, place, place.grounds.dunes.around),
  bands: (ctx, place) => sky(ctx, place, place.grounds.bands.around),
  panes: (ctx, place) => beams(ctx, place, place.colours.shoulderRay, place.grounds.panes.around.beams),
  plates: (ctx, place) => hazard(ctx, place),
  court: (ctx, place) => bounces(ctx, place),
};

/**
 * The plate's colour, darker towards the bottom.
 * @param {CanvasRenderingContext2D} ctx @param {Palette} colours @param {number} width @param {number} height
 */
export function paintEnamel(ctx, { board, boardDeep }, width, height) {
  const enamel = ctx.createLinearGradient(0, 0, 0, height);
  enamel.addColorStop(0, board);
  enamel.addColorStop(1, boardDeep);
  ctx.fillStyle = enamel;
  ctx.fillRect(0, 0, width, height);
}

/**
 * Visits evenly spread places, the same in each call: Roberts' R2 sequence.
 * @param {number} count @param {(x: number, y: number, i: number) => void} visit 0 … 1, 0 … 1
 */
function scatter(count, visit) {
  for (let i = 0; i < count; i += 1) visit((0.5 + i * 0.7548776662) % 1, (0.5 + i * 0.569840291) % 1, i);
}

/** @param {number} width @returns {number[]} the x of a wave's points, from one end to the other */
function across(width) {
  return Array.from({ length: BENDS + 1 }, (_, i) => (i * width) / BENDS);
}

/**
 * The sunburst: every other wedge, from the place where balls start.
 * @param {CanvasRenderingContext2D} ctx @param {Place} place @param {string} colour
 */
function rays(ctx, { x, y, width, height, rays: count }, colour) {
  const reach = width + height;
  ctx.fillStyle = colour;
  for (let ray = 0; ray < count; ray += 2) {
    const from = ((ray + 0.5) / count) * TURN;
    const to = ((ray + 1.5) / count) * TURN;
    ctx.beginPath();
    ctx.moveTo(x, y);
    ctx.lineTo(x + reach * Math.cos(from), y + reach * Math.sin(from));
    ctx.lineTo(x + reach * Math.cos(to), y + reach * Math.sin(to));
    ctx.fill();
  }
}

/**
 * Stars and distant planets.
 * @param {CanvasRenderingContext2D} ctx @param {Place} place @param {{stars: number, planets: Planet[]}} sky
 */
function sky(ctx, place, { stars: count, planets }) {
  stars(ctx, place, count);
  for (const body of planets) planet(ctx, place, body);
}

/** @param {CanvasRenderingContext2D} ctx @param {Place} place @param {number} count */
function stars(ctx, { width, height, grounds: { step } }, count) {
  ctx.fillStyle = "#ffffff";
  scatter(count, (x, y, i) => {
    ctx.globalAlpha = 0.25 + 0.6 * ((i * step) % 1);
    disc(ctx, x * width, y * height, (0.0006 + 0.0013 * ((i * 0.3819) % 1)) * width + 0.3);
  });
  ctx.globalAlpha = 1;
}

/**
 * A planet lit from the upper left.
 * @param {CanvasRenderingContext2D} ctx @param {Place} place @param {Planet} body
 */
function planet(ctx, { width, height }, { x, y, size, colours }) {
  const [cx, cy, radius] = [x * width, y * height, Math.max(2, size * width)];
  const light = ctx.createRadialGradient(
    cx - 0.4 * radius, cy - 0.4 * radius, 0.1 * radius, cx, cy, radius,
  );
  colours.forEach((colour, i) => light.addColorStop(i / (colours.length - 1), colour));
  ctx.fillStyle = light;
  disc(ctx, cx, cy, radius);
}

/** The Moon: craters, each with a lit rim on the side away from the light. @type {Paint} */
function craters(ctx, { width, height, colours, grounds: { step, craters: { plate } } }) {
  const { count, least, more, alpha, rim } = plate;
  scatter(count, (x, y, i) => {
    const radius = width * (least + more * ((i * step) % 1) ** 2);
    const [cx, cy] = [x * width, y * height];
    ctx.globalAlpha = rim.alpha;
    ctx.fillStyle = colours.ray;
    disc(ctx, cx + rim.shift * radius, cy + rim.shift * radius, rim.size * radius);
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours.boardDeep;
    disc(ctx, cx, cy, radius);
  });
}

/** Mars: one dune behind the other. @type {Paint} */
function dunes(ctx, { width, height, colours, grounds: { step, dunes: { plate } } }) {
  const { count, ripple, alphas } = plate;
  for (let i = 0; i < count; i += 1) {
    const top = height * (plate.top + (plate.reach * i) / count);
    const swell = plate.swell * height;
    const shift = ((i * step) % 1) * width;
    ctx.globalAlpha = alphas[i % 2];
    ctx.fillStyle = i % 2 ? colours.boardDeep : colours.ray;
    ctx.beginPath();
    ctx.moveTo(0, height);
    for (const x of across(width)) {
      const phase = ((x + shift) / width) * TURN;
      ctx.lineTo(x, top + swell * (Math.sin(phase) + ripple.part * Math.sin(ripple.times * phase + i)));
    }
    ctx.lineTo(width, height);
    ctx.fill();
  }
}

/** Jupiter: belts and zones of clouds, and the great spot. @type {Paint} */
function bands(ctx, place) {
  const { width, height, colours, grounds: { bands: { plate } } } = place;
  const [upper, lower] = plate.edges.map(({ swell, times, shift }) =>
    (/** @type {number} */ x, /** @type {number} */ i) => swell * height * Math.sin((times * x) / width + shift * i));
  let top = plate.top * height;
  plate.thick.forEach((part, i) => {
    const thick = part * height;
    ctx.globalAlpha = plate.alphas[i % 2];
    ctx.fillStyle = i % 2 ? colours.boardDeep : colours.ray;
    ctx.beginPath();
    for (const x of across(width)) ctx.lineTo(x, top + upper(x, i));
    for (const x of across(width).reverse()) ctx.lineTo(x, top + thick + lower(x, i));
    ctx.fill();
    top += thick + plate.between * height;
  });
  spot(ctx, place);
}

/** @type {Paint} */
function spot(ctx, { width, height, grounds: { bands: { plate } } }) {
  const { x, y, across, down, colour, rings } = plate.spot;
  ctx.fillStyle = colour;
  for (const [size, alpha] of rings) {
    ctx.globalAlpha = alpha;
    ctx.beginPath();
    ctx.ellipse(x * width, y * height, across * size * width, down * size * height, 0, 0, TURN);
    ctx.fill();
  }
}

/** Glass: panes in their leads, and the light that falls through them. @type {Paint} */
function panes(ctx, place) {
  const { width, height, colours, grounds: { panes: { plate } } } = place;
  beams(ctx, place, colours.ray, plate.beams);
  const side = plate.side * width;
  const slant = plate.slant * height;
  ctx.globalAlpha = plate.alpha;
  ctx.strokeStyle = colours.rail;
  ctx.lineWidth = Math.max(1, plate.line * width);
  ctx.beginPath();
  for (let x = -Math.ceil(slant / side) * side; x < width + slant; x += side) {
    ctx.moveTo(x, 0);
    ctx.lineTo(x + slant, height);
    ctx.moveTo(x, 0);
    ctx.lineTo(x - slant, height);
  }
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {Place} place @param {string} colour @param {number} alpha */
function beams(ctx, { width, height, grounds: { panes: { beams: { slant, dim, at: places } } } }, colour, alpha) {
  ctx.fillStyle = colour;
  places.forEach(([at, wide], i) => {
    ctx.globalAlpha = alpha * (i % 2 ? dim : 1);
    ctx.beginPath();
    ctx.moveTo(at * width, 0);
    ctx.lineTo((at + wide) * width, 0);
    ctx.lineTo((at + wide) * width - slant * height, height);
    ctx.lineTo(at * width - slant * height, height);
    ctx.fill();
  });
  ctx.globalAlpha = 1;
}

/** Steel: brushed plates, riveted along their seams. @type {Paint} */
function plates(ctx, { width, height, colours, grounds: { step, plates: { plate } } }) {
  const { every, alphas, seams, seam, rivets } = plate;
  ctx.strokeStyle = colours.ray;
  ctx.lineWidth = 1;
  for (let y = 1; y < height; y += every) {
    ctx.globalAlpha = alphas[0] + alphas[1] * ((y * step) % 1);
    strokeLine(ctx, 0, y, width, y);
  }
  for (const at of seams) {
    const y = Math.round(at * height);
    ctx.globalAlpha = seam.alpha;
    ctx.fillStyle = colours.railShade;
    ctx.fillRect(0, y, width, seam.high);
    ctx.globalAlpha = rivets.alpha;
    ctx.fillStyle = colours.pegDark;
    for (let i = 0.5; i < rivets.count; i += 1) {
      disc(ctx, (i / rivets.count) * width, y - rivets.above * width, rivets.size * width);
    }
  }
}

/** The warning stripes along a machine's floor. @type {Paint} */
function hazard(ctx, { width, height, colours, grounds: { plates: { around: { stripe } } } }) {
  ctx.fillStyle = colours.shoulderRay;
  const step = stripe * width;
  for (let x = -height; x < width + height; x += 2 * step) {
    ctx.beginPath();
    ctx.moveTo(x, height);
    ctx.lineTo(x + step, height);
    ctx.lineTo(x + step + height, 0);
    ctx.lineTo(x + height, 0);
    ctx.fill();
  }
}

/** Rubber: a playground's lines. @type {Paint} */
function court(ctx, { x, width, height, colours, grounds: { court: { plate } } }) {
  const { y, circle, goal, line, alpha } = plate;
  ctx.globalAlpha = alpha;
  ctx.strokeStyle = colours.ray;
  ctx.lineWidth = Math.max(2, line * width);
  ctx.beginPath();
  ctx.arc(x, y * height, circle * width, 0, TURN);
  ctx.moveTo(0, y * height);
  ctx.lineTo(width, y * height);
  ctx.moveTo(x, 0);
  ctx.lineTo(x, height);
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(x, height, goal * width, Math.PI, TURN);
  ctx.stroke();
}

/** The path of a ball that bounces away to the side. @type {Paint} */
function bounces(ctx, { width, height, colours, grounds: { court: { around } } }) {
  const { y, bounces: count, nearer, lower, line, dash } = around;
  ctx.strokeStyle = colours.shoulderRay;
  ctx.lineWidth = Math.max(2, line * width);
  ctx.setLineDash([dash * width, dash * width]);
  for (const side of [-1, 1]) {
    let [x, reach, high] = [0.5 * width, around.reach * width, around.high * height];
    for (let i = 0; i < count; i += 1) {
      ctx.beginPath();
      ctx.ellipse(x + side * reach, y * height, reach, high, 0, Math.PI, TURN);
      ctx.stroke();
      x += 2 * side * reach;
      reach *= nearer;
      high *= lower;
    }
  }
  ctx.setLineDash([]);
}
