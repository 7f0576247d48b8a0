// The ball through a loupe: what is near it, how it turns, where it goes, what an impact gave it.

import { paintArrow, paintPath } from "../paint/marks.js";
import { fitted } from "../board/stage.js";

const REACH = 4; // ball radii from the middle to the rim
const LONGEST = 1.6; // ball radii: the arrow of the greatest speed

/** Draws on a round canvas over the board; gets out of the ball's way. */
export class CloseUp {
  #fastest = 1;

  /** @param {HTMLCanvasElement} canvas @param {import("../paint/theme.js").Theme} theme */
  constructor(canvas, theme) {
    this.canvas = canvas;
    this.theme = theme;
  }

  /** @param {import("./replay.js").Replay} replay */
  load({ board, motion }) {
    this.board = board;
    const speeds = motion.events.map(({ before }) => Math.hypot(before.vx, before.vy));
    this.#fastest = Math.max(1e-9, ...speeds);
  }

  /**
   * @param {import("../model/motion/flight.js").State} state
   * @param {{x: number, y: number}[]} path metres
   * @param {import("../model/impact.js").Impact | null} impact the chosen one, if it is now
   * @param {number} strongest impulse of the drop, N s
   */
  draw(state, path, impact, strongest) {
    const width = this.canvas.clientWidth;
    if (width === 0) return;
    const ctx = fitted(this.canvas, { width, height: width });
    const { radius } = this.board.ball;
    const scale = width / (2 * REACH * radius);
    const lens = {
      scale,
      px: (x) => width / 2 + (x - state.x) * scale,
      py: (y) => width / 2 + (y - state.y) * scale,
    };
    this.#paintBoard(ctx, lens, width, state);
    const near = 1.5 * REACH * radius;
    const { palette } = this.theme;
    for (const piece of pieces(path, state, near)) {
      paintPath(ctx, lens, piece, { colour: palette.trayMark, width: 1.5, alpha: 0.6 });
    }
    this.#paintBall(ctx, lens, state);
    if (impact?.normal) this.#paintImpact(ctx, lens, impact, strongest);
    else this.#paintSpeed(ctx, lens, state);
  }

  /** Keeps to the corner of the board that the ball is not in. @param {{x: number, y: number}} at CSS px */
  avoid({ x, y }) {
    const { offsetLeft: left, offsetTop: top, offsetWidth: size } = this.canvas;
    const covered = x > left - 20 && x < left + size + 20 && y < top + size + 20;
    if (covered) this.canvas.dataset.side = this.canvas.dataset.side === "left" ? "right" : "left";
  }

  #paintBoard(ctx, { px, py, scale }, width, state) {
    const { palette } = this.theme;
    const reach = Math.SQRT2 * REACH * this.board.ball.radius;
    ctx.fillStyle = palette.board;
    ctx.fillRect(0, 0, width, width);
    ctx.fillStyle = palette.peg;
    ctx.strokeStyle = palette.pegDark;
    ctx.lineWidth = 1.5;
    for (const { x, y, radius } of this.board.pegs) {
      if (Math.abs(x - state.x) > reach + radius || Math.abs(y - state.y) > reach + radius) continue;
      ctx.beginPath();
      ctx.arc(px(x), py(y), radius * scale, 0, 2 * Math.PI);
      ctx.fill();
      ctx.stroke();
    }
    const line = (colour, x1, y1, x2, y2) => {
      ctx.strokeStyle = colour;
      ctx.beginPath();
      ctx.moveTo(px(x1), py(y1));
      ctx.lineTo(px(x2), py(y2));
      ctx.stroke();
    };
    ctx.lineWidth = 2;
    for (const { x1, y1, x2, y2 } of this.board.walls) line(palette.rail, x1, y1, x2, y2);
    const { y, edges } = this.board.bins;
    line(palette.trayMark, edges[0], y, edges[edges.length - 1], y);
  }

  /** A disc with a stripe, so that its turning is seen. */
  #paintBall(ctx, { px, py, scale }, { x, y, theta }) {
    const { ball, ballBand, ballDark } = this.theme.palette;
    const radius = this.board.ball.radius * scale;
    ctx.save();
    ctx.translate(px(x), py(y));
    ctx.rotate(theta);
    ctx.globalAlpha = 0.85;
    ctx.fillStyle = ball;
    ctx.beginPath();
    ctx.arc(0, 0, radius, 0, 2 * Math.PI);
    ctx.fill();
    ctx.clip();
    ctx.fillStyle = ballBand;
    ctx.fillRect(-radius, -0.12 * radius, 2 * radius, 0.24 * radius);
    ctx.restore();
    ctx.strokeStyle = ballDark;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.arc(px(x), py(y), radius, 0, 2 * Math.PI);
    ctx.stroke();
  }

  #paintSpeed(ctx, { px, py, scale }, { x, y, vx, vy }) {
    const { flash, railShade } = this.theme.palette;
    const long = (LONGEST * this.board.ball.radius * scale) / this.#fastest;
    const by = { x: long * vx, y: long * vy };
    paintArrow(ctx, { x: px(x), y: py(y) }, by, { colour: flash, rim: railShade, width: 4 });
  }

  #paintImpact(ctx, { px, py, scale }, { point, normal, impulse }, strongest) {
    const { palette } = this.theme;
    const long = 2 * this.board.ball.radius * scale;
    paintImpact(ctx, { x: px(point.x), y: py(point.y) }, { normal, impulse, strongest, long }, palette);
  }
}

/**
 * The normal as a thin arrow, the impulse as a thick one, as long as it is strong.
 * @param {CanvasRenderingContext2D} ctx
 * @param {{x: number, y: number}} at the point of contact, CSS pixels
 * @param {{normal: {x: number, y: number}, impulse: {x: number, y: number}, strongest: number,
 *   long: number}} what long: CSS pixels of a middling arrow
 * @param {import("../paint/theme.js").Palette} palette
 */
export function paintImpact(ctx, at, { normal, impulse, strongest, long }, palette) {
  const rim = palette.railShade;
  const out = { x: 1.4 * long * normal.x, y: 1.4 * long * normal.y };
  paintArrow(ctx, at, out, { colour: palette.rail, rim, width: long / 24 });
  const size = Math.hypot(impulse.x, impulse.y);
  if (size === 0) return;
  // A weak one is still long enough to show where it points.
  const reach = (1.1 * long * Math.max(0.35, size / strongest)) / size;
  const push = { x: reach * impulse.x, y: reach * impulse.y };
  paintArrow(ctx, at, push, { colour: palette.trayBar, rim, width: long / 8 });
}

/** The stretches of a path that are near a place. */
function* pieces(path, { x, y }, near) {
  let piece = [];
  for (const point of path) {
    const inside = Math.abs(point.x - x) < near && Math.abs(point.y - y) < near;
    if (inside) piece.push(point);
    if (!inside && piece.length) {
      yield piece;
      piece = [];
    }
  }
  if (piece.length) yield piece;
}
