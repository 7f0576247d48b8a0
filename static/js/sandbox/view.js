// The box on two canvases: what never moves, and the balls with what the hand is doing.

import { makeSprite, paintBall } from "../paint/ball.js";

const STEPS = 3.5; // sprites of different radii in each doubling; in between they are stretched
const LARGEST = 64; // CSS pixels; larger balls stretch this one, whose stamps still fit a canvas

/**
 * @typedef {object} Hand
 * @property {{x: number, y: number}} cross where the keyboard aims, metres
 * @property {boolean} crossShown
 * @property {{x: number, y: number, toX: number, toY: number, radius: number} | null} sling metres
 * @property {number | null} chosen a ball
 */

/** Draws one place and its balls. */
export class SandboxView {
  #sprites = new Map();
  #stamp = { sheet: null, half: 0, side: 0 };
  #width = 0;
  #density = 0;

  /** @param {{still: HTMLCanvasElement, moving: HTMLCanvasElement}} canvases
   *  @param {import("../paint/theme.js").Theme} theme @param {() => void} onLayout */
  constructor({ still, moving }, theme, onLayout) {
    this.still = still;
    this.moving = moving;
    this.theme = theme;
    this.onLayout = onLayout;
    new ResizeObserver(() => this.relayout()).observe(still.parentElement);
    theme.onChange(() => this.repaint());
  }

  /** @param {any} place its JSON form @param {any} extent */
  setPlace(place, extent) {
    this.place = place;
    this.extent = extent;
    const ratio = (extent.x_max - extent.x_min) / (extent.y_max - extent.y_min);
    document.documentElement.style.setProperty("--board-ratio", ratio.toFixed(4));
    document.documentElement.dataset.shape = ratio < 1 ? "tall" : "wide";
    this.#width = 0;
    this.relayout();
  }

  /** Fits the canvases to their box; does nothing when nothing has changed. */
  relayout() {
    const width = this.still.parentElement.clientWidth;
    const density = window.devicePixelRatio || 1;
    if (!this.place || !width || (width === this.#width && density === this.#density)) return;
    this.#width = width;
    this.#density = density;
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.extent;
    const { pad } = this.theme.shapes.box; // CSS pixels around what stands
    this.scale = (width - 2 * pad) / (x1 - x0);
    this.height = Math.round((y1 - y0) * this.scale + 2 * pad);
    this.width = width;
    for (const canvas of [this.still, this.moving]) {
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(this.height * density);
      canvas.style.height = `${this.height}px`;
    }
    this.repaint();
  }

  px(x) {
    return this.theme.shapes.box.pad + (x - this.extent.x_min) * this.scale;
  }

  py(y) {
    return this.theme.shapes.box.pad + (y - this.extent.y_min) * this.scale;
  }

  /** @param {PointerEvent} event @returns {{x: number, y: number}} metres */
  placeOf(event) {
    const box = this.moving.getBoundingClientRect();
    const { pad } = this.theme.shapes.box;
    return {
      x: (event.clientX - box.left - pad) / this.scale + this.extent.x_min,
      y: (event.clientY - box.top - pad) / this.scale + this.extent.y_min,
    };
  }

  /** Paints the still layer anew: colours, size or place have changed. */
  repaint() {
    if (!this.scale) return;
    this.#sprites.clear();
    const ctx = this.still.getContext("2d");
    ctx.setTransform(this.#density, 0, 0, this.#density, 0, 0);
    this.#paintGround(ctx);
    this.#paintPlace(ctx);
    this.onLayout();
  }

  #paintGround(ctx) {
    const { palette } = this.theme;
    const enamel = ctx.createLinearGradient(0, 0, 0, this.height);
    enamel.addColorStop(0, palette.board);
    enamel.addColorStop(1, palette.boardDeep);
    ctx.fillStyle = enamel;
    ctx.fillRect(0, 0, this.width, this.height);
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

  #paintPlace(ctx) {
    const { palette } = this.theme;
    ctx.lineCap = "round";
    ctx.strokeStyle = palette.rail;
    const { least, most, metres } = this.theme.shapes.box;
    const width = Math.max(least, Math.min(most, metres * this.scale));
    const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = this.extent;
    for (const wall of this.place.walls) {
      // A wall has no thickness; on the rim its rail lies outside, so that balls touch its edge.
      const atX = wall.x1 === wall.x2 && (wall.x1 === x0 || wall.x1 === x1);
      const atY = wall.y1 === wall.y2 && (wall.y1 === y0 || wall.y1 === y1);
      const dx = atX ? Math.sign(2 * wall.x1 - x0 - x1) * (width / 2) : 0;
      const dy = atY ? Math.sign(2 * wall.y1 - y0 - y1) * (width / 2) : 0;
      ctx.lineWidth = width;
      ctx.beginPath();
      ctx.moveTo(this.px(wall.x1) + dx, this.py(wall.y1) + dy);
      ctx.lineTo(this.px(wall.x2) + dx, this.py(wall.y2) + dy);
      ctx.stroke();
    }
    ctx.fillStyle = palette.peg;
    for (const peg of this.place.pegs) disc(ctx, this.px(peg.x), this.py(peg.y), peg.radius * this.scale);
    if (!this.place.bins) return;
    const { y, edges } = this.place.bins;
    ctx.fillStyle = palette.trayMark;
    ctx.fillRect(this.px(edges[0]), this.py(y) - 1, this.px(edges.at(-1)) - this.px(edges[0]), 2);
    for (const edge of edges) ctx.fillRect(this.px(edge) - 1, this.py(y) - 8, 2, 8);
  }

  /**
   * @param {(see: (ball: import("./room.js").Seen) => void) => void} look
   * @param {Hand} hand
   */
  draw(look, hand) {
    if (!this.scale) return;
    const ctx = this.moving.getContext("2d");
    const density = this.#density;
    ctx.setTransform(density, 0, 0, density, 0, 0);
    ctx.clearRect(0, 0, this.width, this.height);
    let chosen = null;
    look((ball) => {
      this.#paintBall(ctx, ball);
      if (ball.id === hand.chosen) chosen = { ...ball };
    });
    if (chosen) this.#ring(ctx, chosen);
    if (hand.sling) this.#arrow(ctx, hand.sling);
    if (hand.crossShown) this.#cross(ctx, hand.cross);
  }

  #paintBall(ctx, { x, y, angle, radius, asleep }) {
    const size = radius * this.scale;
    const { sprite, of } = this.#spriteOf(size, asleep);
    this.#stamp.sheet = sprite.sheet;
    this.#stamp.side = sprite.side;
    this.#stamp.half = (sprite.half * size) / of;
    paintBall(ctx, this.#stamp, this.px(x), this.py(y), angle);
  }

  /** A sprite of about this radius in pixels, and the radius that it is of. */
  #spriteOf(size, asleep) {
    // Radii in steps of a constant ratio: small balls differ visibly by less than large ones.
    const step = Math.round(Math.log2(Math.min(LARGEST, size)) * STEPS);
    const key = 2 * step + (asleep ? 1 : 0);
    let found = this.#sprites.get(key);
    if (!found) {
      const { palette } = this.theme;
      const of = 2 ** (step / STEPS);
      const colours = asleep
        ? { body: palette.other, dark: palette.otherDark, light: "#ffffff", band: palette.otherDark }
        : { body: palette.ball, dark: palette.ballDark, light: palette.ballLight, band: palette.ballBand };
      const sprite = makeSprite(
        of, this.#density, { ...colours, shadow: palette.shadow }, this.theme.shapes.ball,
      );
      found = { sprite, of };
      this.#sprites.set(key, found);
    }
    return found;
  }

  #ring(ctx, { x, y, radius }) {
    ctx.strokeStyle = this.theme.palette.flash;
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.arc(this.px(x), this.py(y), radius * this.scale + 3, 0, 2 * Math.PI);
    ctx.stroke();
  }

  #arrow(ctx, { x, y, toX, toY, radius }) {
    const { palette } = this.theme;
    const [fromX, fromY, tipX, tipY] = [this.px(x), this.py(y), this.px(toX), this.py(toY)];
    ctx.globalAlpha = 0.6;
    ctx.fillStyle = palette.ball;
    disc(ctx, fromX, fromY, radius * this.scale);
    ctx.globalAlpha = 1;
    const length = Math.hypot(tipX - fromX, tipY - fromY);
    if (length < 6) return;
    const [ux, uy] = [(tipX - fromX) / length, (tipY - fromY) / length];
    ctx.strokeStyle = palette.flash;
    ctx.lineWidth = 3;
    ctx.beginPath();
    ctx.moveTo(fromX, fromY);
    ctx.lineTo(tipX, tipY);
    ctx.moveTo(tipX - 12 * ux - 7 * uy, tipY - 12 * uy + 7 * ux);
    ctx.lineTo(tipX, tipY);
    ctx.lineTo(tipX - 12 * ux + 7 * uy, tipY - 12 * uy - 7 * ux);
    ctx.stroke();
  }

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

function disc(ctx, x, y, radius) {
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.fill();
}
