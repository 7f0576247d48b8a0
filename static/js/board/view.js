// The board on two canvases: one that never moves, one that is redrawn only where it did.
// Knows boards, scenes and colours; nothing of the network.

import { layOut } from "../paint/geometry.js";
import { Damage } from "../paint/damage.js";
import {
  makeFlashes, makeSprite, paintBall, paintFlash, paintPaid, traceTrail,
} from "../paint/ball.js";
import { binBox, paintBoard } from "../paint/board.js";
import { beamHeight, paintPulse, pulseOf } from "../paint/bin.js";

const PAID_RISE = 46; // CSS pixels that a paid score climbs

/**
 * Everything that moves at one moment; metres, radians.
 * @typedef {object} Scene
 * @property {SceneBall[]} balls
 * @property {{x: number, y: number, radius: number, age: number, strength: number}[]} flashes
 *   pegs just hit; age and strength 0 … 1
 * @property {{bin: number, age: number, score: number, ticket?: boolean}[]} hits bins just hit;
 *   age 0 … 1; without a ticket what it paid is not written above it
 * @property {{x: number, y: number}[][]} paths whole paths, as lines
 * @property {number | null} aim where a ball would start
 * @property {number | null} [chosen] id of the ball that is measured
 *
 * @typedef {object} SceneBall
 * @property {number} x
 * @property {number} y
 * @property {number} angle
 * @property {boolean} mine
 * @property {Float64Array} trail x y x y …, newest first
 * @property {number} trailCount
 * @property {number} [id]
 */

/** @returns {Scene} */
export function emptyScene() {
  return { balls: [], flashes: [], hits: [], paths: [], aim: null, chosen: null };
}

/** Draws one board and the scenes on it. `onLayout(geometry)` tells when the size changed. */
export class BoardView {
  /** @type {import("../paint/geometry.js").Geometry | null} */
  geometry = null;
  #damage = new Damage();
  #points = new Float64Array(64);

  /**
   * @param {{still: HTMLCanvasElement, moving: HTMLCanvasElement}} canvases the second on top
   * @param {import("../paint/theme.js").Theme} theme
   * @param {(geometry: import("../paint/geometry.js").Geometry) => void} onLayout
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
    this.#damage.add(0, 0, this.geometry.width, this.geometry.height);
  }

  /** @param {Scene} scene */
  draw(scene) {
    if (!this.geometry) return;
    const ctx = this.moving.getContext("2d");
    this.#damage.clear(ctx, this.geometry.width, this.geometry.height);
    for (const path of scene.paths) this.#drawPath(ctx, path);
    for (const flash of scene.flashes) this.#drawFlash(ctx, flash);
    this.#drawTrails(ctx, scene.balls, false);
    this.#drawTrails(ctx, scene.balls, true);
    for (const ball of scene.balls) if (!ball.mine) this.#drawBall(ctx, ball);
    for (const ball of scene.balls) if (ball.mine) this.#drawBall(ctx, ball);
    for (const ball of scene.balls) if (ball.id === scene.chosen) this.#drawChosen(ctx, ball);
    if (scene.aim !== null) this.#drawAim(ctx, scene.aim);
    for (const hit of scene.hits) this.#drawHit(ctx, hit);
    for (const hit of scene.hits) if (hit.ticket ?? true) this.#drawPaid(ctx, hit);
  }

  /** @param {PointerEvent | MouseEvent} event @returns {{x: number, y: number, above: boolean} | null} */
  aimOf(event) {
    if (!this.geometry) return null;
    const box = this.still.getBoundingClientRect();
    return {
      x: this.geometry.x(event.clientX - box.left),
      y: this.geometry.y(event.clientY - box.top),
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
    const { palette, shapes: { ball } } = this.theme;
    this.radius = this.board.ball.radius * this.geometry.scale;
    const { ballLight: light, shadow } = palette;
    this.sprites = {
      mine: makeSprite(this.radius, this.#density, {
        body: palette.ball, dark: palette.ballDark, light, band: palette.ballBand, shadow,
      }, ball),
      other: makeSprite(this.radius, this.#density, {
        body: palette.other, dark: palette.otherDark, light: "#ffffff",
        band: palette.otherDark, shadow,
      }, ball),
    };
    const largest = this.board.pegs.reduce((most, { radius }) => Math.max(most, radius), 0.01);
    this.flashes = makeFlashes(largest * this.geometry.scale, this.#density, palette.flash);
  }

  #drawTrails(ctx, balls, mine) {
    const { px, py } = this.geometry;
    const points = this.#points;
    const { palette, shapes: { trail } } = this.theme;
    ctx.beginPath();
    for (const ball of balls) {
      if (ball.mine !== mine) continue;
      const count = Math.min(ball.trailCount, points.length / 2);
      for (let i = 0; i < count; i += 1) {
        points[2 * i] = px(ball.trail[2 * i]);
        points[2 * i + 1] = py(ball.trail[2 * i + 1]);
      }
      traceTrail(ctx, points, count, trail.width * this.radius);
      this.#damage.addPoints(points, count, this.radius + 2);
    }
    ctx.globalAlpha = trail.alpha;
    ctx.fillStyle = mine ? palette.ball : palette.other;
    ctx.fill();
    ctx.globalAlpha = 1;
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
    paintBall(ctx, mine ? this.sprites.mine : this.sprites.other, atX, atY, angle);
    if (sinking) ctx.restore();
    this.#touch(atX, atY, 1.6 * radius + 3);
  }

  /** The ball whose speed is measured wears a ring. */
  #drawChosen(ctx, { x, y }) {
    const { px, py } = this.geometry;
    const reach = this.radius + 5;
    ctx.strokeStyle = this.theme.palette.trayMark;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.arc(px(x), py(y), reach, 0, 2 * Math.PI);
    ctx.stroke();
    this.#touch(px(x), py(y), reach + 2);
  }

  #drawFlash(ctx, { x, y, radius, age, strength }) {
    const { px, py, scale } = this.geometry;
    const reach = paintFlash(ctx, this.flashes, px(x), py(y), radius * scale, age, strength);
    this.#touch(px(x), py(y), reach + 1);
  }

  #drawHit(ctx, { bin, age, score }) {
    const box = binBox(this.geometry, this.board, bin);
    const pulse = pulseOf(score, age);
    paintPulse(ctx, this.still, box, pulse, this.theme, this.#density, score);
    const beam = beamHeight(box, pulse);
    const { x, y, width, height } = box;
    this.#damage.add(x - 6, y - beam - 6, width + 12, height + beam + 18);
  }

  #drawPaid(ctx, { bin, age, score }) {
    const { x, y, width } = binBox(this.geometry, this.board, bin);
    const size = Math.max(15, Math.min(34, 0.3 * this.geometry.scale));
    const middle = Math.max(1.6 * size, Math.min(this.geometry.width - 1.6 * size, x + width / 2));
    const at = y - size - PAID_RISE * (1 - (1 - age) ** 3);
    const { palette } = this.theme;
    paintPaid(ctx, middle, at, size, score, age, this.theme.payout(score), palette.shadow);
    this.#damage.add(middle - 2.4 * size, at - size, 4.8 * size, 2.2 * size);
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
    this.#damage.add(at - this.radius - 12, 0, 2 * this.radius + 24, aimBottom + this.radius);
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
    this.#damage.add(0, 0, width, height);
  }

  #touch(x, y, reach) {
    this.#damage.add(x - reach, y - reach, 2 * reach, 2 * reach);
  }
}
