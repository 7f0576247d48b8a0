// Paints scenes over one board at one size in one theme, and clears only what it painted last.

import { labelOf } from "../model/board.js";
import { fillTrail, makeFlashes, paintBall, paintFlash, paintLight, paintPaid } from "../paint/ball.js";
import { beamHeight, facesOf, paintPulse, pulseOf } from "../paint/bin.js";
import { binBox } from "../paint/board.js";
import { Damage } from "../paint/damage.js";
import { paintNote, paintPath, paintRing } from "../paint/marks.js";
import { NameBook, placeNames } from "../paint/names.js";
import { coloursOf, prizeOf } from "../paint/prizes.js";
import { t } from "../texts/text.js";
import { StampBook } from "../paint/stamps.js";
import { metric, multiplier } from "../util/format.js";

/** @import { Board, Point } from "../model/board.js" */
/** @import { BinHit, Flash, Parting, Scene, SceneBall, Streak } from "../model/scene.js" */
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

/** Caches the stamps of balls and pegs; another size or theme needs another painter. */
export class ScenePainter {
  #damage = new Damage();
  #points = new Float64Array(64);
  /** @type {ReturnType<typeof facesOf> | null} */
  #faces = null;
  /** @type {ReturnType<typeof makeFlashes> | null} */
  #flashes = null;
  /** Balls by the colour of their tails. @type {Map<string, SceneBall[]>} */
  #tails = new Map();
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
    // The previous painter may have left something on the canvas.
    this.#damage.add(0, 0, geometry.width, geometry.height);
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

  /** @param {CanvasRenderingContext2D} ctx scaled to CSS pixels @param {Scene} scene */
  draw(ctx, scene) {
    this.#damage.clear(ctx, this.geometry.width, this.geometry.height);
    for (const path of scene.paths) this.#drawPath(ctx, path);
    for (const streak of scene.streaks ?? []) this.#drawStreak(ctx, streak);
    if (scene.fork) this.#drawFork(ctx, scene.fork);
    for (const flash of scene.flashes) this.#drawFlash(ctx, flash);
    this.#drawTrails(ctx, scene.balls);
    for (const ball of scene.balls) if (!ball.mine) this.#drawBall(ctx, ball);
    for (const ball of scene.balls) if (ball.mine) this.#drawBall(ctx, ball);
    this.#drawNames(ctx, scene.balls);
    if (scene.aim !== null) this.#drawAim(ctx, scene.aim);
    for (const hit of scene.hits) this.#drawHit(ctx, hit);
    for (const hit of scene.hits) if (hit.ticket ?? true) this.#drawPaid(ctx, hit);
  }

  /**
   * Draws the trails colour by colour, those of the player's own balls last. A trail covers the last
   * moments of the path, so a faster ball has a longer one.
   * @param {CanvasRenderingContext2D} ctx @param {SceneBall[]} balls
   */
  #drawTrails(ctx, balls) {
    for (const tails of this.#tails.values()) tails.length = 0;
    for (const ball of balls) this.#tailsOf(ball).push(ball);
    const { trail } = this.theme.shapes;
    ctx.save();
    this.#clipAboveBins(ctx);
    for (const mine of [false, true]) {
      for (const [colour, tails] of this.#tails) {
        if (!tails.some((ball) => ball.mine === mine)) continue;
        ctx.fillStyle = colour;
        this.#fillTrails(ctx, tails, mine, { ...trail, part: 1 });
        if (mine) this.#fillTrails(ctx, tails, mine, trail.core);
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

  /** @param {SceneBall} ball @returns {SceneBall[]} the balls whose trails have its colour */
  #tailsOf(ball) {
    const { colour } = this.stamps.of(ball);
    let tails = this.#tails.get(colour);
    if (!tails) this.#tails.set(colour, (tails = []));
    return tails;
  }

  /**
   * @param {CanvasRenderingContext2D} ctx
   * @param {SceneBall[]} balls
   * @param {boolean} mine whether to draw the player's own balls, or the others
   * @param {{width: number, alpha: number, part: number}} shape part: of the trail's length
   */
  #fillTrails(ctx, balls, mine, { width, alpha, part }) {
    const { px, py } = this.geometry;
    const points = this.#points;
    ctx.globalAlpha = alpha;
    for (const ball of balls) {
      if (ball.mine !== mine) continue;
      const count = Math.min(Math.ceil(part * ball.trailCount), points.length / 2);
      for (let i = 0; i < count; i += 1) {
        points[2 * i] = px(ball.trail[2 * i]);
        points[2 * i + 1] = py(ball.trail[2 * i + 1]);
      }
      fillTrail(ctx, points, count, width * this.radius);
      if (part === 1) this.#damage.addPoints(points, count, this.radius + 2);
    }
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
    this.#touch(atX, atY, Math.max(1.6 * radius, halo.half) + 3);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {SceneBall[]} balls */
  #drawNames(ctx, balls) {
    const { px, py, width, binTop } = this.geometry;
    const plates = balls.filter(({ name }) => name).map(({ id, name = "", x, y }) => (
      { ...this.names.of(name), ball: id, x: px(x), y: Math.min(py(y), binTop) }));
    this.#placed = placeNames(plates, { width, height: binTop, reach: this.radius + 2 }, this.#placed);
    for (const { box, sheet } of this.#placed.values()) {
      ctx.drawImage(sheet, box.x, box.y, box.width, box.height);
      this.#damage.add(box.x - 1, box.y - 1, box.width + 2, box.height + 2);
    }
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Flash} flash */
  #drawFlash(ctx, { x, y, radius, age, strength }) {
    const { px, py, scale } = this.geometry;
    const reach = paintFlash(ctx, this.flashes, px(x), py(y), radius * scale, age, strength);
    this.#touch(px(x), py(y), reach + 1);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {BinHit} binHit */
  #drawHit(ctx, { bin, age, score }) {
    const box = binBox(this.geometry, this.board, bin);
    const pulse = pulseOf(score, age);
    paintPulse(ctx, this.faces, box, pulse, this.theme, this.density, score);
    const beam = beamHeight(box, pulse);
    const { x, y, width, height } = box;
    this.#damage.add(x - 6, y - beam - 16, width + 12, height + beam + 32);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {BinHit} binHit */
  #drawPaid(ctx, { bin, age, score }) {
    const { x, y, width } = binBox(this.geometry, this.board, bin);
    const size = Math.max(15, Math.min(34, 0.3 * this.geometry.scale));
    const middle = Math.max(1.6 * size, Math.min(this.geometry.width - 1.6 * size, x + width / 2));
    const at = y - size - PAID_RISE * (1 - (1 - age) ** 3);
    const { palette } = this.theme;
    const colours = coloursOf(labelOf(this.board, bin), this.theme.payout(score));
    const wide = paintPaid(ctx, middle, at, size, prizeOf(this.board, bin, score), age, colours, palette.shadow);
    this.#damage.add(middle - wide / 2 - 4, at - size, wide + 8, 2.2 * size);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {number} x */
  #drawAim(ctx, x) {
    const { px, dropY, aimBottom } = this.geometry;
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
    this.#damage.add(at - this.radius - 12, 0, 2 * this.radius + 24, aimBottom + this.radius);
  }

  /** @param {CanvasRenderingContext2D} ctx @param {Point[]} path */
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

  /** @param {CanvasRenderingContext2D} ctx @param {Streak} streak */
  #drawStreak(ctx, { points, age }) {
    const { width, height } = this.geometry;
    const { palette } = this.theme;
    const left = (1 - age) ** 1.5;
    const line = Math.max(2, 0.55 * this.radius);
    for (const [colour, wide, alpha] of /** @type {const} */ ([
      [palette.ball, 2.4 * line, 0.3], [palette.ball, line, 0.9], [palette.ballLight, 0.4 * line, 0.9],
    ])) {
      paintPath(ctx, this.geometry, points, { colour, width: wide, alpha: alpha * left });
    }
    this.#damage.add(0, 0, width, height);
  }

  /**
   * Marks the impact at which the two paths part, and draws the second ball's path from there.
   * @param {CanvasRenderingContext2D} ctx @param {Parting} fork
   */
  #drawFork(ctx, { at, path, hair, score }) {
    const { px, py, width, height } = this.geometry;
    const { palette } = this.theme;
    const line = Math.max(1.5, 0.3 * this.radius);
    const aside = { colour: palette.other, width: line, alpha: 0.75, dash: [2 * line, 2.5 * line] };
    paintPath(ctx, this.geometry, path, aside);
    paintRing(ctx, px(at.x), py(at.y), 2 * this.radius, { colour: palette.flash, width: line });
    const size = Math.max(11, Math.min(16, 0.16 * this.geometry.scale));
    paintNote(ctx, t("play.aside", { hair: metric(hair), pays: multiplier(score) }), {
      x: px(at.x), y: py(at.y), gap: 2 * this.radius + size, size, width,
    }, palette);
    this.#damage.add(0, 0, width, height);
  }

  /** @param {number} x @param {number} y @param {number} reach */
  #touch(x, y, reach) {
    this.#damage.add(x - reach, y - reach, 2 * reach, 2 * reach);
  }
}
