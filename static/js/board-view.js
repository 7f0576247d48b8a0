// The board on two canvases: one that never moves, one that is redrawn only where it did.
// Knows boards, scenes and colours; nothing of the network.

import { layOut } from "./geometry.js";
import {
  flashRadius, makeSprite, paintBall, paintFlash, paintPaid, paintTrail,
} from "./paint-ball.js";
import { binBox, paintBin, paintBoard } from "./paint-board.js";

const PAID_RISE = 46; // CSS pixels that a paid score climbs

/**
 * Everything that moves at one moment; metres, radians.
 * @typedef {object} Scene
 * @property {SceneBall[]} balls
 * @property {{x: number, y: number, radius: number, age: number, strength: number}[]} flashes
 *   pegs just hit; age and strength 0 … 1
 * @property {{bin: number, age: number, score: number}[]} hits bins just hit; age 0 … 1
 * @property {{x: number, y: number}[][]} paths whole paths, as lines
 * @property {number | null} aim where a ball would start
 *
 * @typedef {object} SceneBall
 * @property {number} x
 * @property {number} y
 * @property {number} angle
 * @property {boolean} mine
 * @property {Float64Array} trail x y x y …, newest first
 * @property {number} trailCount
 */

/** @returns {Scene} */
export function emptyScene() {
  return { balls: [], flashes: [], hits: [], paths: [], aim: null };
}

/** Draws one board and the scenes on it. `onLayout(geometry)` tells when the size changed. */
export class BoardView {
  /** @type {import("./geometry.js").Geometry | null} */
  geometry = null;
  #dirty = [];
  #points = new Float64Array(64);

  /**
   * @param {{still: HTMLCanvasElement, moving: HTMLCanvasElement}} canvases the second on top
   * @param {import("./theme.js").Theme} theme
   * @param {(geometry: import("./geometry.js").Geometry) => void} onLayout
   */
  constructor({ still, moving }, theme, onLayout) {
    this.still = still;
    this.moving = moving;
    this.theme = theme;
    this.onLayout = onLayout;
    new ResizeObserver(() => this.relayout()).observe(still.parentElement);
    this.#followDensity();
  }

  /** @param {any} board the JSON form @param {number[]} slots */
  setBoard(board, slots) {
    this.board = board;
    this.slots = slots;
    this.#width = 0;
    this.relayout();
  }

  #width = 0;
  #density = 0;

  /** Fits the canvases to their box and the display; does nothing when neither has changed. */
  relayout() {
    const width = this.still.parentElement.clientWidth;
    const density = window.devicePixelRatio || 1;
    if (!this.board || !width || (width === this.#width && density === this.#density)) return;
    this.#width = width;
    this.#density = density;
    this.geometry = layOut(this.board, width);
    for (const canvas of [this.still, this.moving]) this.#fit(canvas);
    this.repaint();
    this.onLayout(this.geometry);
  }

  /** Paints the still layer anew: colours or size have changed. */
  repaint() {
    if (!this.geometry) return;
    const ctx = this.still.getContext("2d");
    paintBoard(ctx, this.geometry, this.board, this.slots, this.theme);
    this.#makeSprites();
    this.#dirty = [[0, 0, this.geometry.width, this.geometry.height]];
  }

  /** @param {Scene} scene */
  draw(scene) {
    if (!this.geometry) return;
    const ctx = this.moving.getContext("2d");
    for (const [x, y, width, height] of this.#dirty) ctx.clearRect(x, y, width, height);
    this.#dirty.length = 0;
    for (const path of scene.paths) this.#drawPath(ctx, path);
    for (const flash of scene.flashes) this.#drawFlash(ctx, flash);
    for (const ball of scene.balls) this.#drawTrail(ctx, ball);
    for (const ball of scene.balls) this.#drawBall(ctx, ball);
    if (scene.aim !== null) this.#drawAim(ctx, scene.aim);
    for (const hit of scene.hits) this.#drawHit(ctx, hit);
    for (const hit of scene.hits) this.#drawPaid(ctx, hit);
  }

  /** @param {PointerEvent | MouseEvent} event @returns {{x: number, above: boolean} | null} */
  aimOf(event) {
    if (!this.geometry) return null;
    const box = this.still.getBoundingClientRect();
    return {
      x: this.geometry.x(event.clientX - box.left),
      above: event.clientY - box.top <= this.geometry.aimBottom,
    };
  }

  #fit(canvas) {
    const { width, height } = this.geometry;
    canvas.width = Math.round(width * this.#density);
    canvas.height = Math.round(height * this.#density);
    canvas.style.height = `${height}px`;
    canvas.getContext("2d").setTransform(this.#density, 0, 0, this.#density, 0, 0);
  }

  /** Another screen or another zoom changes the pixel ratio without changing the box. */
  #followDensity() {
    const query = window.matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`);
    query.addEventListener("change", () => {
      this.relayout();
      this.#followDensity();
    }, { once: true });
  }

  #makeSprites() {
    const { palette } = this.theme;
    this.radius = this.board.ball.radius * this.geometry.scale;
    const light = palette.ballLight;
    this.sprites = {
      mine: makeSprite(this.radius, this.#density, {
        body: palette.ball, dark: palette.ballDark, light, band: palette.ballBand,
      }),
      other: makeSprite(this.radius, this.#density, {
        body: palette.other, dark: palette.otherDark, light: "#ffffff", band: palette.otherDark,
      }),
    };
  }

  #drawTrail(ctx, { trail, trailCount, mine }) {
    const { px, py } = this.geometry;
    const count = Math.min(trailCount, this.#points.length / 2);
    for (let i = 0; i < count; i += 1) {
      this.#points[2 * i] = px(trail[2 * i]);
      this.#points[2 * i + 1] = py(trail[2 * i + 1]);
    }
    const { palette } = this.theme;
    paintTrail(ctx, this.#points, count, this.radius, mine ? palette.ball : palette.other);
    this.#touchPoints(count, this.radius + 2);
  }

  #drawBall(ctx, { x, y, angle, mine }) {
    const { px, py, binTop, width } = this.geometry;
    const atX = px(x);
    const atY = py(y);
    const { radius } = this;
    const sinking = atY + radius > binTop + 2;
    if (sinking) {
      // A landed ball goes on into its pocket, behind the pocket's face.
      ctx.save();
      ctx.beginPath();
      ctx.rect(0, 0, width, binTop + 2);
      ctx.clip();
    }
    ctx.globalAlpha = 0.35;
    ctx.fillStyle = this.theme.palette.shadow;
    ctx.beginPath();
    ctx.arc(atX + 0.28 * radius, atY + 0.5 * radius, radius, 0, 2 * Math.PI);
    ctx.fill();
    ctx.globalAlpha = 1;
    paintBall(ctx, mine ? this.sprites.mine : this.sprites.other, atX, atY, angle);
    if (sinking) ctx.restore();
    this.#touch(atX, atY, 1.6 * radius + 3);
  }

  #drawFlash(ctx, { x, y, radius, age, strength }) {
    const { px, py, scale } = this.geometry;
    const size = radius * scale;
    paintFlash(ctx, px(x), py(y), size, age, strength, this.theme.palette.flash);
    this.#touch(px(x), py(y), flashRadius(size, 1, strength) + 1);
  }

  #drawHit(ctx, { bin, age, score }) {
    const { x, y, width, height } = binBox(this.geometry, this.board, bin);
    const { flash } = this.theme.palette;
    paintBin(ctx, this.geometry, this.board, bin, this.theme.payout(score), (1 - age) ** 2, flash);
    this.#dirty.push([x - 4, y - 4, width + 8, height + 14]);
  }

  #drawPaid(ctx, { bin, age, score }) {
    const { x, y, width } = binBox(this.geometry, this.board, bin);
    const size = Math.max(15, Math.min(34, 0.3 * this.geometry.scale));
    const middle = Math.max(1.6 * size, Math.min(this.geometry.width - 1.6 * size, x + width / 2));
    const at = y - size - PAID_RISE * (1 - (1 - age) ** 3);
    const { palette } = this.theme;
    paintPaid(ctx, middle, at, size, score, age, this.theme.payout(score), palette.shadow);
    this.#dirty.push([middle - 2.4 * size, at - size, 4.8 * size, 2.2 * size]);
  }

  #drawAim(ctx, x) {
    const { px, dropY, aimBottom } = this.geometry;
    const at = px(x);
    ctx.globalAlpha = 0.55;
    paintBall(ctx, this.sprites.mine, at, dropY, 0);
    ctx.globalAlpha = 1;
    ctx.fillStyle = this.theme.palette.rail;
    ctx.beginPath();
    const tip = dropY - this.radius - 6;
    ctx.moveTo(at, tip);
    ctx.lineTo(at - 8, tip - 12);
    ctx.lineTo(at + 8, tip - 12);
    ctx.fill();
    this.#dirty.push([at - this.radius - 12, 0, 2 * this.radius + 24, aimBottom + this.radius]);
  }

  #drawPath(ctx, path) {
    const { px, py, width, height } = this.geometry;
    ctx.strokeStyle = this.theme.palette.trayMark;
    ctx.globalAlpha = 0.75;
    ctx.lineWidth = Math.max(1.5, 0.25 * this.radius);
    ctx.lineJoin = "round";
    ctx.beginPath();
    for (const { x, y } of path) ctx.lineTo(px(x), py(y));
    ctx.stroke();
    ctx.globalAlpha = 1;
    this.#dirty.push([0, 0, width, height]);
  }

  #touch(x, y, reach) {
    this.#dirty.push([x - reach, y - reach, 2 * reach, 2 * reach]);
  }

  #touchPoints(count, margin) {
    if (count === 0) return;
    let left = Number.POSITIVE_INFINITY;
    let top = Number.POSITIVE_INFINITY;
    let right = Number.NEGATIVE_INFINITY;
    let bottom = Number.NEGATIVE_INFINITY;
    for (let i = 0; i < count; i += 1) {
      left = Math.min(left, this.#points[2 * i]);
      right = Math.max(right, this.#points[2 * i]);
      top = Math.min(top, this.#points[2 * i + 1]);
      bottom = Math.max(bottom, this.#points[2 * i + 1]);
    }
    const width = right - left + 2 * margin;
    this.#dirty.push([left - margin, top - margin, width, bottom - top + 2 * margin]);
  }
}
