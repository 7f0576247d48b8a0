// Paints the places that boards stand in: what is printed on the plate, and what lies around it.

import { disc } from "../util/canvas.js";

/** @import { Palette } from "./theme.js" */

/**
 * @typedef {object} Place
 * @property {number} x where balls start, CSS pixels
 * @property {number} y
 * @property {number} width of the picture, CSS pixels
 * @property {number} height
 * @property {Palette} colours
 * @property {number} rays wedges of the sunburst, printed and not
 *
 * @typedef {(ctx: CanvasRenderingContext2D, place: Place) => void} Paint
 */

const TURN = 2 * Math.PI;

/** What is printed on the plate, between the walls. @type {Record<string, Paint>} */
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

/** What lies around the plate, beyond the walls. @type {Record<string, Paint>} */
export const SURROUNDINGS = {
  rays: (ctx, place) => rays(ctx, place, place.colours.shoulderRay),
  craters: (ctx, place) => {
    stars(ctx, place, 90);
    planet(ctx, place, { x: 0.13, y: 0.2, size: 0.062, colours: ["#e9f6ff", "#4b9be0", "#123f7a"] });
  },
  dunes: (ctx, place) => {
    planet(ctx, place, { x: 0.87, y: 0.14, size: 0.03, colours: ["#ffffff", "#dcecff", "#9fc0e6"] });
    planet(ctx, place, { x: 0.1, y: 0.22, size: 0.018, colours: ["#e8c7a4", "#b98a66", "#6d4833"] });
    planet(ctx, place, { x: 0.19, y: 0.13, size: 0.01, colours: ["#e8d3bd", "#b99c80", "#6d5846"] });
  },
  bands: (ctx, place) => {
    stars(ctx, place, 50);
    planet(ctx, place, { x: 0.1, y: 0.3, size: 0.03, colours: ["#fff2b8", "#e5c04e", "#8a5f1d"] });
    planet(ctx, place, { x: 0.2, y: 0.15, size: 0.02, colours: ["#ffffff", "#d9d3c4", "#8c8271"] });
    planet(ctx, place, { x: 0.86, y: 0.2, size: 0.042, colours: ["#d8c7b0", "#8f7b66", "#40342b"] });
  },
  panes: (ctx, place) => beams(ctx, place, place.colours.shoulderRay, 0.9),
  plates: (ctx, place) => hazard(ctx, place),
  court: (ctx, place) => bounces(ctx, place),
};

/**
 * Places spread evenly, the same each time: steps of Roberts' R2 sequence.
 * @param {number} count @param {(x: number, y: number, i: number) => void} visit 0 … 1, 0 … 1
 */
function scatter(count, visit) {
  for (let i = 0; i < count; i += 1) visit((0.5 + i * 0.7548776662) % 1, (0.5 + i * 0.569840291) % 1, i);
}

/**
 * The printed sunburst: every other wedge, out of the place where balls start.
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

/** @param {CanvasRenderingContext2D} ctx @param {Place} place @param {number} count */
function stars(ctx, { width, height }, count) {
  ctx.fillStyle = "#ffffff";
  scatter(count, (x, y, i) => {
    ctx.globalAlpha = 0.25 + 0.6 * ((i * 0.618034) % 1);
    disc(ctx, x * width, y * height, (0.0006 + 0.0013 * ((i * 0.3819) % 1)) * width + 0.3);
  });
  ctx.globalAlpha = 1;
}

/**
 * A world far away, lit from the upper left.
 * @param {CanvasRenderingContext2D} ctx @param {Place} place
 * @param {{x: number, y: number, size: number, colours: string[]}} body in parts of the width and height; colours
 *   from its lit side to its dark one
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
function craters(ctx, { width, height, colours }) {
  scatter(44, (x, y, i) => {
    const radius = width * (0.008 + 0.034 * ((i * 0.618034) % 1) ** 2);
    const [cx, cy] = [x * width, y * height];
    ctx.globalAlpha = 0.5;
    ctx.fillStyle = colours.ray;
    disc(ctx, cx + 0.12 * radius, cy + 0.12 * radius, 1.12 * radius);
    ctx.globalAlpha = 0.4;
    ctx.fillStyle = colours.boardDeep;
    disc(ctx, cx, cy, radius);
  });
}

/** Mars: one dune behind the other. @type {Paint} */
function dunes(ctx, { width, height, colours }) {
  const count = 9;
  for (let i = 0; i < count; i += 1) {
    const top = height * (0.12 + (0.92 * i) / count);
    const swell = 0.045 * height;
    const shift = ((i * 0.618034) % 1) * width;
    ctx.globalAlpha = i % 2 ? 0.5 : 0.42;
    ctx.fillStyle = i % 2 ? colours.boardDeep : colours.ray;
    ctx.beginPath();
    ctx.moveTo(0, height);
    for (let x = 0; x <= width; x += width / 48) {
      const phase = ((x + shift) / width) * TURN;
      ctx.lineTo(x, top + swell * (Math.sin(phase) + 0.4 * Math.sin(2.3 * phase + i)));
    }
    ctx.lineTo(width, height);
    ctx.fill();
  }
}

/** Jupiter: belts and zones of cloud, and the great spot. @type {Paint} */
function bands(ctx, { width, height, colours }) {
  const widths = [0.05, 0.07, 0.035, 0.09, 0.05, 0.11, 0.04, 0.08, 0.06];
  let top = 0.06 * height;
  widths.forEach((part, i) => {
    const thick = part * height;
    ctx.globalAlpha = i % 2 ? 0.5 : 0.36;
    ctx.fillStyle = i % 2 ? colours.boardDeep : colours.ray;
    ctx.beginPath();
    for (let x = 0; x <= width; x += width / 60) {
      ctx.lineTo(x, top + 0.006 * height * Math.sin((9 * x) / width + 2 * i));
    }
    for (let x = width; x >= 0; x -= width / 60) {
      ctx.lineTo(x, top + thick + 0.008 * height * Math.sin((13 * x) / width + 3 * i));
    }
    ctx.fill();
    top += thick + 0.045 * height;
  });
  ctx.fillStyle = "#a8452c";
  for (const [size, alpha] of [[1, 0.35], [0.72, 0.4], [0.42, 0.45]]) {
    ctx.globalAlpha = alpha;
    ctx.beginPath();
    ctx.ellipse(0.6 * width, 0.66 * height, 0.12 * size * width, 0.055 * size * height, 0, 0, TURN);
    ctx.fill();
  }
}

/** Glass: panes in their leads, and the light that falls through them. @type {Paint} */
function panes(ctx, place) {
  const { width, height, colours } = place;
  beams(ctx, place, colours.ray, 0.75);
  const side = width / 7;
  ctx.globalAlpha = 0.28;
  ctx.strokeStyle = colours.rail;
  ctx.lineWidth = Math.max(1, 0.0018 * width);
  ctx.beginPath();
  for (let i = -8; i < 16; i += 1) {
    ctx.moveTo(i * side, 0);
    ctx.lineTo(i * side + 0.6 * height, height);
    ctx.moveTo(i * side, 0);
    ctx.lineTo(i * side - 0.6 * height, height);
  }
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {Place} place @param {string} colour @param {number} alpha */
function beams(ctx, { width, height }, colour, alpha) {
  ctx.fillStyle = colour;
  [[0.02, 0.1], [0.2, 0.04], [0.36, 0.14], [0.62, 0.05], [0.78, 0.12], [1.02, 0.08]].forEach(([at, wide], i) => {
    ctx.globalAlpha = alpha * (i % 2 ? 0.55 : 1);
    ctx.beginPath();
    ctx.moveTo(at * width, 0);
    ctx.lineTo((at + wide) * width, 0);
    ctx.lineTo((at + wide) * width - 0.35 * height, height);
    ctx.lineTo(at * width - 0.35 * height, height);
    ctx.fill();
  });
  ctx.globalAlpha = 1;
}

/** Steel: brushed plates, riveted along their seams. @type {Paint} */
function plates(ctx, { width, height, colours }) {
  ctx.strokeStyle = colours.ray;
  ctx.lineWidth = 1;
  for (let y = 1; y < height; y += 3) {
    ctx.globalAlpha = 0.15 + 0.4 * ((y * 0.618034) % 1);
    ctx.beginPath();
    ctx.moveTo(0, y);
    ctx.lineTo(width, y);
    ctx.stroke();
  }
  const seams = [0.3, 0.56, 0.82];
  for (const seam of seams) {
    const y = Math.round(seam * height);
    ctx.globalAlpha = 0.55;
    ctx.fillStyle = colours.railShade;
    ctx.fillRect(0, y, width, 2);
    ctx.globalAlpha = 0.5;
    ctx.fillStyle = colours.pegDark;
    for (let x = 0.5; x < 24; x += 1) disc(ctx, (x / 24) * width, y - 0.014 * width, 0.0045 * width);
  }
}

/** The warning stripes along a machine's floor. @type {Paint} */
function hazard(ctx, { width, height, colours }) {
  ctx.fillStyle = colours.shoulderRay;
  const step = width / 16;
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
function court(ctx, { x, width, height, colours }) {
  ctx.globalAlpha = 0.7;
  ctx.strokeStyle = colours.ray;
  ctx.lineWidth = Math.max(2, 0.008 * width);
  ctx.beginPath();
  ctx.arc(x, 0.6 * height, 0.14 * width, 0, TURN);
  ctx.moveTo(0, 0.6 * height);
  ctx.lineTo(width, 0.6 * height);
  ctx.moveTo(x, 0);
  ctx.lineTo(x, height);
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(x, height, 0.3 * width, Math.PI, TURN);
  ctx.stroke();
}

/** The way of a ball that bounces off to the side. @type {Paint} */
function bounces(ctx, { width, height, colours }) {
  ctx.strokeStyle = colours.shoulderRay;
  ctx.lineWidth = Math.max(2, 0.006 * width);
  ctx.setLineDash([0.014 * width, 0.014 * width]);
  for (const side of [-1, 1]) {
    let [x, reach, high] = [0.5 * width, 0.17 * width, 0.42 * height];
    for (let i = 0; i < 5; i += 1) {
      ctx.beginPath();
      ctx.ellipse(x + side * reach, 0.55 * height, reach, high, 0, Math.PI, TURN);
      ctx.stroke();
      x += 2 * side * reach;
      reach *= 0.8;
      high *= 0.7;
    }
  }
  ctx.setLineDash([]);
}
