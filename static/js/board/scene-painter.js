// Paints scenes over one board at one size in one theme.

import { labelOf } from "../model/board.js";
import { fillTrail, makeFlashes, paintBall, paintFlash, paintLight, paintPaid } from "../paint/ball.js";
import { facesOf, paintPulse, pulseOf } from "../paint/bin.js";
import { binBox } from "../paint/board.js";
import { paintNote, paintPath, paintRing } from "../paint/marks.js";
import { NameBook, placeNames } from "../paint/names.js";
import { coloursOf, prizeOf } from "../paint/prizes.js";
import { t } from "../texts/text.js";
import { StampBook } from "../paint/stamps.js";
import { metric, multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */
/** @import { BinHit, Parting, Scene, SceneBall, Streak } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */
/** @import { Theme } from "../paint/theme.js" */

const PAID_RISE = 46; // CSS pixels that a score rises

/**
 * @typedef {object} Ground the board that scenes are painted over
 * @property {HTMLCanvasElement} still the painted board
 * @property {Board} board
 * @property {Geometry} geometry
 * @property {number} density device pixels a CSS pixel
 */

/**
 * Paints over the balls, below their names.
 * @typedef {(ctx: CanvasRenderingContext2D, painter: ScenePainter) => void} Overlay
 */

/** Caches the stamps of balls and pegs; another size or theme needs another painter. */
export class ScenePainter {
  /** @type {ReturnType<typeof facesOf> | null} */
  #faces = null;
  /** @type {ReturnType<typeof makeFlashes> | null} */
  #flashes = null;
  /** The names in the last picture. @type {ReturnType<typeof placeNames>} */
  #placed = new Map();

  /** @param {Ground} ground @param {Theme} theme */
  constructor({ still, board, geometry, density }, theme) {
    this.board = board;
    this.geometry = geometry;
    this.density = density;
    this.theme = theme;
    this.radius = board.ball.radius * geometry.scale;
    this.still = still;
    this.stamps = new StampBook(this.radius, density, theme);
    this.names = new NameBook(Math.max(12, Math.min(26, 0.2 * geometry.scale)), density);
  }

  /** The bins at rest, kept from when a ball first hits one. */
  get faces() {
    return (this.#faces ??= facesOf(this.still, Math.floor(this.geometry.binTop * this.density)));
  }

  /** The stamps of flashes, made for the first one. */
  get flashes() {
    const largest = this.board.pegs.reduce((most, peg) => Math.max(most, peg.radius), 0.01);
    return (this.#flashes ??= makeFlashes(largest * this.geometry.scale, this.density, this.theme.palette.flash));
  }

  /**
   * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels @param {Scene} scene
   * @param {Overlay} paintOver
   */
  draw(ctx, scene, paintOver) {
    ctx.clearRect(0, 0, this.geometry.width, this.geometry.height);
    const style = { colour: this.theme.palette.trayMark, width: Math.max(1.5, 0.25 * this.radius), alpha: 0.75 };
    for (const path of scene.paths) paintPath(ctx, this.geometry, path, style);
    for (const streak of scene.streaks ?? []) this.#drawStreak(ctx, streak);
    if (scene.fork) this.#drawFork(ctx, scene.fork);
    const { px, py, scale } = this.geometry;
    for (const { x, y, radius, age, strength } of scene.flashes) {
      paintFlash(ctx, this.flashes, px(x), py(y), radius * scale, age, strength);
    }
    this.#drawTrails(ctx, scene.balls);
    for (const ball of scene.balls) if (!ball.mine) this.#drawBall(ctx, ball);
    for (const ball of scene.balls) if (ball.mine) this.#drawBall(ctx, ball);
    paintOver(ctx, this);
    this.#drawNames(ctx, scene.balls);
    if (scene.aim !== null) this.#drawAim(ctx, scene.aim);
    for (const { bin, age, score } of scene.hits) {
      const box = binBox(this.geometry, this.board, bin);
      paintPulse(ctx, this.faces, box, pulseOf(score, age), this.theme, this.density, score);
    }
    for (const hit of scene.hits) if (hit.ticket ?? true) this.#drawPaid(ctx, hit);
  }

  /**
   * Draws the trails, those of the player's own balls last. A trail covers the last moments of the path, so a
   * faster ball has a longer one.
   * @param {CanvasRenderingContext2D} ctx @param {SceneBall[]} balls
   */
  #drawTrails(ctx, balls) {
    const { px, py } = this.geometry;
    const { trail } = this.theme.shapes;
    ctx.save();
    this.#clipAboveBins(ctx);
    for (const own of [false, true]) {
      for (const ball of balls) {
        if (ball.mine !== own) continue;
        ctx.fillStyle = this.stamps.of(ball).colour;
        const points = ball.trail.map(({ x, y }) => ({ x: px(x), y: py(y) }));
        for (const { width, alpha, part } of own ? [{ ...trail, part: 1 }, trail.core] : [{ ...trail, part: 1 }]) {
          ctx.globalAlpha = alpha;
          fillTrail(ctx, points.slice(0, Math.ceil(part * points.length)), width * this.radius);
        }
      }
    }
    ctx.restore();
  }

  /** Clips to the part above the bins: a landed ball sinks behind its bin's face. @param {CanvasRenderingContext2D} ctx */
  #clipAboveBins(ctx) {
    const { binTop, width } = this.geometry;
    ctx.beginPath();
    ctx.rect(0, 0, width, binTop + 2);
    ctx.clip();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {SceneBall} ball */
  #drawBall(ctx, ball) {
    const { x, y, angle } = ball;
    const { px, py, binTop } = this.geometry;
    const atX = px(x);
    const atY = py(y);
    const { radius } = this;
    const sinking = atY + radius > binTop + 2;
    if (sinking) {
      ctx.save();
      this.#clipAboveBins(ctx);
    }
    const { halo, body } = this.stamps.of(ball);
    paintLight(ctx, halo, atX, atY);
    paintBall(ctx, body, atX, atY, angle);
    if (sinking) ctx.restore();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {SceneBall[]} balls */
  #drawNames(ctx, balls) {
    const { px, py, width, binTop } = this.geometry;
    const plates = balls.filter(({ name }) => name).map(({ id, name = "", x, y }) => (
      { ...this.names.of(name), ball: id, x: px(x), y: Math.min(py(y), binTop) }));
    this.#placed = placeNames(plates, { width, height: binTop, reach: this.radius + 2 }, this.#placed);
    for (const { box, sheet } of this.#placed.values()) {
      ctx.drawImage(sheet, box.x, box.y, box.width, box.height);
    }
  }

  /** @param {CanvasRenderingContext2D} ctx @param {BinHit} binHit */
  #drawPaid(ctx, { bin, age, score }) {
    const { x, y, width } = binBox(this.geometry, this.board, bin);
    const size = Math.max(15, Math.min(34, 0.3 * this.geometry.scale));
    const middle = Math.max(1.6 * size, Math.min(this.geometry.width - 1.6 * size, x + width / 2));
    const at = y - size - PAID_RISE * (1 - (1 - age) ** 3);
    const { palette } = this.theme;
    const colours = coloursOf(labelOf(this.board, bin), this.theme.payout(score));
    paintPaid(ctx, middle, at, size, prizeOf(this.board, bin, score), age, colours, palette.shadow);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {number} x */
  #drawAim(ctx, x) {
    const { px, dropY } = this.geometry;
    const at = px(x);
    ctx.globalAlpha = 0.55;
    paintBall(ctx, this.stamps.of({ mine: true }).body, at, dropY, 0);
    ctx.globalAlpha = 1;
    ctx.fillStyle = this.theme.palette.rail;
    ctx.beginPath();
    const tip = dropY - this.radius - 6;
    ctx.moveTo(at, tip);
    ctx.lineTo(at - 8, tip - 12);
    ctx.lineTo(at + 8, tip - 12);
    ctx.fill();
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Streak} streak */
  #drawStreak(ctx, { points, age }) {
    const { palette } = this.theme;
    const left = (1 - age) ** 1.5;
    const line = Math.max(2, 0.55 * this.radius);
    for (const [colour, wide, alpha] of /** @type {const} */ ([
      [palette.ball, 2.4 * line, 0.3], [palette.ball, line, 0.9], [palette.ballLight, 0.4 * line, 0.9],
    ])) {
      paintPath(ctx, this.geometry, points, { colour, width: wide, alpha: alpha * left });
    }
  }

  /**
   * Marks the impact at which the two paths part, and draws the second ball's path from there.
   * @param {CanvasRenderingContext2D} ctx @param {Parting} fork
   */
  #drawFork(ctx, { at, path, hair, score }) {
    const { px, py, width } = this.geometry;
    const { palette } = this.theme;
    const line = Math.max(1.5, 0.3 * this.radius);
    const aside = { colour: palette.other, width: line, alpha: 0.75, dash: [2 * line, 2.5 * line] };
    paintPath(ctx, this.geometry, path, aside);
    paintRing(ctx, px(at.x), py(at.y), 2 * this.radius, { colour: palette.flash, width: line });
    const size = Math.max(11, Math.min(16, 0.16 * this.geometry.scale));
    paintNote(ctx, t("play.aside", { hair: metric(hair), pays: multiplier(score) }), {
      x: px(at.x), y: py(at.y), gap: 2 * this.radius + size, size, width,
    }, palette);
  }
}
