// Draws the box on two canvases: one for what never moves, one for the balls and the pointer's aim.

import { announceShape, StageFit } from "../board/stage-fit.js";
import { makeSprite, paintBall } from "../paint/ball.js";
import { paintEnamel } from "../paint/ground.js";
import { paintArrow, paintRing } from "../paint/marks.js";
import { shaded } from "../paint/stamps.js";
import { disc, fitted, strokeLine } from "../util/canvas.js";
import { byId, parentOf } from "../util/dom.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Seen } from "./room.js" */
/** @import { Point } from "../model/board.js" */
/** @import { Extent, StaticGeometry } from "../model/messages.js" */
/** @import { Sprite } from "../paint/ball.js" */
/** @import { Sling } from "./pointer.js" */

const STEPS = 3.5; // sprites for each doubling of the radius; other radii are scaled from the nearest
const TINTS = 3; // colours for each doubling of the radius
const USUAL = 0.12; // m: the radius of a ball in the theme's colour
const COLOURS = ["#ff86d0", "#c08cff", "#86a2ff", "#57c7ff", "#4fe3b1", "#ffe169"]; // of larger balls, in a circle
const DIM = 0.62; // brightness of balls at rest
const LARGEST = 64; // CSS pixels: radius of the largest sprite whose sheet fits a canvas; larger balls scale it

/**
 * The pointer controller's state, to be drawn.
 * @typedef {object} Aim
 * @property {Point} cross where the keyboard aims, m
 * @property {boolean} crossShown
 * @property {Sling | null} sling
 * @property {number | null} chosen the selected ball
 */

/** Draws a box and its balls. */
export class SandboxView {
  /** @type {Extent} m */
  extent = { x_min: 0, x_max: 1, y_min: 0, y_max: 1 };
  /** CSS pixels per metre; 0 before the first layout. */
  scale = 0;
  /** @type {StaticGeometry | null} */
  #geometry = null;
  #height = 0;
  /** @type {Map<string, {sprite: Sprite, of: number}>} of: the sprite's radius, CSS pixels */
  #sprites = new Map();
  #width = 0;
  #density = 0;

  /** @param {Theme} theme @param {() => void} onLayout */
  constructor(theme, onLayout) {
    this.still = byId("board-still", HTMLCanvasElement);
    this.moving = byId("board-moving", HTMLCanvasElement);
    this.theme = theme;
    this.onLayout = onLayout;
    this.fit = new StageFit(parentOf(this.still), () => this.relayout());
    theme.onChange(() => this.repaint());
  }

  /** @param {StaticGeometry} geometry walls, pegs and bins @param {Extent} extent */
  setGeometry(geometry, extent) {
    this.#geometry = geometry;
    this.extent = extent;
    const ratio = (extent.x_max - extent.x_min) / (extent.y_max - extent.y_min);
    announceShape(ratio);
    this.#width = 0;
    this.relayout();
  }

  /** Fits the canvases to their box, if its size has changed. */
  relayout() {
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.extent;
    const { pad } = this.theme.shapes.box; // CSS pixels around the extent
    if (!this.#geometry) return;
    const width = this.fit.fit((wide) => ((y1 - y0) * (wide - 2 * pad)) / (x1 - x0) + 2 * pad + 1);
    const density = window.devicePixelRatio || 1;
    if (!width || (width === this.#width && density === this.#density)) return;
    this.#width = width;
    this.#density = density;
    this.scale = (width - 2 * pad) / (x1 - x0);
    this.#height = Math.round((y1 - y0) * this.scale + 2 * pad);
    for (const canvas of [this.still, this.moving]) canvas.style.height = `${this.#height}px`;
    this.repaint();
  }

  /** @param {number} x m @returns {number} CSS pixels */
  px(x) {
    return this.theme.shapes.box.pad + (x - this.extent.x_min) * this.scale;
  }

  /** @param {number} y m @returns {number} CSS pixels */
  py(y) {
    return this.theme.shapes.box.pad + (y - this.extent.y_min) * this.scale;
  }

  /** @param {PointerEvent} event @returns {{x: number, y: number}} m */
  placeOf(event) {
    const box = this.moving.getBoundingClientRect();
    const { pad } = this.theme.shapes.box;
    return {
      x: (event.clientX - box.left - pad) / this.scale + this.extent.x_min,
      y: (event.clientY - box.top - pad) / this.scale + this.extent.y_min,
    };
  }

  /** Repaints the still layer, after a change of colours, size or room. */
  repaint() {
    if (!this.scale || !this.#geometry) return;
    this.#sprites.clear();
    const ctx = fitted(this.still, { width: this.#width, height: this.#height });
    this.#paintBackground(ctx);
    this.#paintGeometry(ctx, this.#geometry);
    this.onLayout();
  }

  /** @param {CanvasRenderingContext2D} ctx */
  #paintBackground(ctx) {
    const { palette } = this.theme;
    paintEnamel(ctx, palette, this.#width, this.#height);
    // A metre grid, so that speeds and sizes can be judged.
    ctx.fillStyle = palette.ray;
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.extent;
    for (let x = Math.ceil(x0); x <= x1; x += 1) {
      ctx.fillRect(this.px(x) - 0.5, this.py(y0), 1, this.py(y1) - this.py(y0));
    }
    for (let y = Math.ceil(y0); y <= y1; y += 1) {
      ctx.fillRect(this.px(x0), this.py(y) - 0.5, this.px(x1) - this.px(x0), 1);
    }
  }

  /** @param {CanvasRenderingContext2D} ctx @param {StaticGeometry} staticGeometry */
  #paintGeometry(ctx, { walls, pegs, bins }) {
    const { palette } = this.theme;
    ctx.lineCap = "round";
    ctx.strokeStyle = palette.rail;
    const { least, most, metres } = this.theme.shapes.box;
    const width = Math.max(least, Math.min(most, metres * this.scale));
    ctx.lineWidth = width;
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.extent;
    for (const wall of walls) {
      // A wall has no thickness. On the rim its rail is drawn outside, so that balls touch the rail's edge.
      const atX = wall.x1 === wall.x2 && (wall.x1 === x0 || wall.x1 === x1);
      const atY = wall.y1 === wall.y2 && (wall.y1 === y0 || wall.y1 === y1);
      const dx = atX ? Math.sign(2 * wall.x1 - x0 - x1) * (width / 2) : 0;
      const dy = atY ? Math.sign(2 * wall.y1 - y0 - y1) * (width / 2) : 0;
      strokeLine(ctx, this.px(wall.x1) + dx, this.py(wall.y1) + dy, this.px(wall.x2) + dx, this.py(wall.y2) + dy);
    }
    ctx.fillStyle = palette.peg;
    for (const peg of pegs) disc(ctx, this.px(peg.x), this.py(peg.y), peg.radius * this.scale);
    if (!bins) return;
    const { y, edges } = bins;
    ctx.fillStyle = palette.trayMark;
    ctx.fillRect(this.px(edges[0]), this.py(y) - 1, this.px(edges[edges.length - 1]) - this.px(edges[0]), 2);
    for (const edge of edges) ctx.fillRect(this.px(edge) - 1, this.py(y) - 8, 2, 8);
  }

  /** @param {Seen[]} balls @param {Aim} aim */
  draw(balls, aim) {
    if (!this.scale) return;
    const ctx = fitted(this.moving, { width: this.#width, height: this.#height });
    for (const ball of balls) this.#paintBall(ctx, ball);
    const ring = { colour: this.theme.palette.flash, width: 2 };
    for (const { id, x, y, radius } of balls) {
      if (id === aim.chosen) paintRing(ctx, this.px(x), this.py(y), radius * this.scale + 3, ring);
    }
    if (aim.sling) this.#arrow(ctx, aim.sling);
    if (aim.crossShown) this.#cross(ctx, aim.cross);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Seen} seen */
  #paintBall(ctx, { x, y, angle, radius, asleep }) {
    const size = radius * this.scale;
    const { sprite, of } = this.#spriteOf(size, radius, asleep);
    const stamp = { sheet: sprite.sheet, side: sprite.side, half: (sprite.half * size) / of };
    paintBall(ctx, stamp, this.px(x), this.py(y), angle);
  }

  /**
   * Returns a sprite of about this radius, in CSS pixels, and its own radius.
   * @param {number} size @param {number} radius m: it gives the colour
   * @param {boolean} asleep
   */
  #spriteOf(size, radius, asleep) {
    // Radii in steps of a constant ratio, because small differences are more visible on small balls.
    const step = Math.round(Math.log2(Math.min(LARGEST, size)) * STEPS);
    const tint = Math.round(TINTS * Math.log2(radius / USUAL));
    const key = `${step} ${tint} ${asleep}`;
    let found = this.#sprites.get(key);
    if (!found) {
      const { palette } = this.theme;
      const of = 2 ** (step / STEPS);
      const all = [palette.ball, ...COLOURS];
      const colour = all[((tint % all.length) + all.length) % all.length];
      const [body, band] = [colour, palette.ballBand].map((each) => (asleep ? shaded(each, DIM) : each));
      const { shadow, ballLight: light } = palette;
      const colours = { body, dark: shaded(body), light, band, shadow };
      const sprite = makeSprite(of, this.#density, colours, this.theme.shapes.ball);
      found = { sprite, of };
      this.#sprites.set(key, found);
    }
    return found;
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Sling} sling */
  #arrow(ctx, { x, y, toX, toY, radius }) {
    const { palette } = this.theme;
    const [fromX, fromY, tipX, tipY] = [this.px(x), this.py(y), this.px(toX), this.py(toY)];
    ctx.globalAlpha = 0.6;
    ctx.fillStyle = palette.ball;
    disc(ctx, fromX, fromY, radius * this.scale);
    ctx.globalAlpha = 1;
    const by = { x: tipX - fromX, y: tipY - fromY };
    if (Math.hypot(by.x, by.y) < 6) return;
    paintArrow(ctx, { x: fromX, y: fromY }, by, { colour: palette.flash, rim: palette.railShade, width: 4 });
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Point} point */
  #cross(ctx, { x, y }) {
    const [px, py] = [this.px(x), this.py(y)];
    ctx.strokeStyle = this.theme.palette.flash;
    ctx.lineWidth = 2;
    ctx.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      ctx.moveTo(px + 5 * dx, py + 5 * dy);
      ctx.lineTo(px + 14 * dx, py + 14 * dy);
    }
    ctx.stroke();
  }
}
