// A magnified view of the ball and its surroundings, with its rotation, and its velocity or an impact's impulse.

import { paintArrow, paintPath, paintRing } from "../paint/marks.js";
import { disc, fitted, strokeLine } from "../util/canvas.js";

/** @import { Impact } from "../model/impact.js" */
/** @import { State } from "../model/motion/flight.js" */
/** @import { Palette, Theme } from "../paint/theme.js" */
/** @import { Replay } from "./replay.js" */
/** @import { Board, Point } from "../model/board.js" */
/** @import { Geometry } from "../paint/geometry.js" */

const REACH = 4; // ball radii from the middle to the rim
const LONGEST = 1.6; // ball radii: length of the arrow at the drop's highest speed

/**
 * Maps metres to the close-up's pixels, with the ball in the middle.
 * @typedef {Pick<Geometry, "px" | "py" | "scale" | "width"> & {ctx: CanvasRenderingContext2D, radius: number}} Lens
 *   radius: of the ball, m
 */

/** Draws on a round canvas over the board, which moves to the other side when the ball would be behind it. */
export class CloseUp {
  /** @param {HTMLCanvasElement} canvas @param {Theme} theme @param {Replay} replay */
  constructor(canvas, theme, replay) {
    this.canvas = canvas;
    this.theme = theme;
    this.replay = replay;
    this.fastest = Math.max(1e-9, ...replay.motion.events.map(({ before }) => Math.hypot(before.vx, before.vy)));
  }

  /**
   * @param {State} state
   * @param {Impact | null} impact the chosen one, if it happens in this state
   * @param {number} strongest impulse of the drop, N s
   */
  draw(state, impact, strongest) {
    const width = this.canvas.clientWidth;
    const { board, path } = this.replay;
    if (width === 0) return;
    const ctx = fitted(this.canvas, { width, height: width });
    const { radius } = board.ball;
    const scale = width / (2 * REACH * radius);
    /** @type {Lens} */
    const lens = {
      ctx, width, scale, radius,
      px: (x) => width / 2 + (x - state.x) * scale,
      py: (y) => width / 2 + (y - state.y) * scale,
    };
    this.#paintBoard(lens, board, state);
    const { palette } = this.theme;
    paintPath(ctx, lens, path, { colour: palette.trayMark, width: 1.5, alpha: 0.6 });
    this.#paintBall(lens, state);
    if (impact?.normal) {
      const { point, normal, impulse } = impact;
      const at = { x: lens.px(point.x), y: lens.py(point.y) };
      paintImpact(ctx, at, { normal, impulse, strongest, long: 2 * radius * scale }, palette);
    } else {
      const { x, y, vx, vy } = state;
      const long = (LONGEST * radius * scale) / this.fastest;
      const look = { colour: palette.flash, rim: palette.railShade, width: 4 };
      paintArrow(ctx, { x: lens.px(x), y: lens.py(y) }, { x: long * vx, y: long * vy }, look);
    }
  }

  /** Moves to the other corner if it would cover the ball. @param {Point} at the ball, CSS pixels */
  avoid({ x, y }) {
    const { offsetLeft: left, offsetTop: top, offsetWidth: size } = this.canvas;
    const covered = x > left - 20 && x < left + size + 20 && y < top + size + 20;
    if (covered) this.canvas.dataset.side = this.canvas.dataset.side === "left" ? "right" : "left";
  }

  /** @param {Lens} lens @param {Board} board @param {State} state */
  #paintBoard({ ctx, px, py, scale, width, radius: ball }, board, state) {
    const { palette } = this.theme;
    const reach = Math.SQRT2 * REACH * ball;
    ctx.fillStyle = palette.board;
    ctx.fillRect(0, 0, width, width);
    ctx.fillStyle = palette.peg;
    ctx.strokeStyle = palette.pegDark;
    ctx.lineWidth = 1.5;
    for (const { x, y, radius } of board.pegs) {
      if (Math.abs(x - state.x) > reach + radius || Math.abs(y - state.y) > reach + radius) continue;
      disc(ctx, px(x), py(y), radius * scale);
      ctx.stroke();
    }
    ctx.lineWidth = 2;
    ctx.strokeStyle = palette.rail;
    for (const { x1, y1, x2, y2 } of board.walls) strokeLine(ctx, px(x1), py(y1), px(x2), py(y2));
    const { y, edges } = board.bins;
    ctx.strokeStyle = palette.trayMark;
    strokeLine(ctx, px(edges[0]), py(y), px(edges[edges.length - 1]), py(y));
  }

  /** Paints a disc with a stripe, which shows the rotation. @param {Lens} lens @param {State} state */
  #paintBall({ ctx, px, py, scale, radius: metres }, { x, y, theta }) {
    const { ball, ballBand, ballDark } = this.theme.palette;
    const radius = metres * scale;
    ctx.save();
    ctx.translate(px(x), py(y));
    ctx.rotate(theta);
    ctx.globalAlpha = 0.85;
    ctx.fillStyle = ball;
    disc(ctx, 0, 0, radius);
    ctx.clip();
    ctx.fillStyle = ballBand;
    ctx.fillRect(-radius, -0.12 * radius, 2 * radius, 0.24 * radius);
    ctx.restore();
    paintRing(ctx, px(x), py(y), radius, { colour: ballDark, width: 1.5 });
  }
}

/**
 * Paints the normal as a thin arrow, and the impulse as a thick one whose length shows its strength.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Point} at the point of contact, CSS pixels
 * @param {{normal: Point, impulse: Point, strongest: number, long: number}} what long: scale of the arrows, CSS pixels
 * @param {Palette} palette
 */
export function paintImpact(ctx, at, { normal, impulse, strongest, long }, palette) {
  const rim = palette.railShade;
  const out = { x: 1.4 * long * normal.x, y: 1.4 * long * normal.y };
  paintArrow(ctx, at, out, { colour: palette.rail, rim, width: long / 24 });
  const size = Math.hypot(impulse.x, impulse.y);
  if (size === 0) return;
  // A weak impulse has a minimum length, so that its direction is visible.
  const reach = (1.1 * long * Math.max(0.35, size / strongest)) / size;
  const push = { x: reach * impulse.x, y: reach * impulse.y };
  paintArrow(ctx, at, push, { colour: palette.trayBar, rim, width: long / 8 });
}
