// Plots one ball's speed and energy against time, from the keyframes of its path.

import { energyOf } from "../../model/impact.js";
import { shortestTurn } from "../../model/motion/interpolate.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { figure } from "../../util/scale.js";
import { Series } from "../../util/series.js";
import { Chart } from "../../instruments/chart.js";
import { energyAreas } from "../../instruments/energy-areas.js";

/** @import { Ball } from "../../model/table/table.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Keyframe } from "../../model/motion/interpolate.js" */
/** @import { Board } from "../../model/board.js" */
/** @import { Game } from "../game.js" */
/** @import { EnergyRow } from "../../instruments/energy-areas.js" */

/** @typedef {EnergyRow & {speed: number}} MeterRow */

const REDRAW_MS = 200;
const NEAR = 3; // ball radii by which a click may miss the ball

/** The followed ball and its two plots. */
export class BallMeter {
  /** @type {number | null} id of the ball that is followed */
  chosen = null;
  /** When the followed ball started, s of table time. */
  #start = 0;
  #series = new Series(["t", "speed", "height", "moving", "turning"]);
  /** @type {{t: number, angle: number} | null} */
  #before = null;
  #shownMs = 0;
  #shownCount = -1;

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.speed = new Chart(byId("speed-plot", HTMLCanvasElement), theme);
    this.energy = new Chart(byId("energy-plot", HTMLCanvasElement), theme);
    this.note = byId("ball-note");
    game.on("table", () => this.#release());
    game.on("snapshot", () => this.measure());
  }

  /** @returns {Ball[]} */
  get #balls() {
    return [...(this.game.room.table?.balls.values() ?? [])];
  }

  /** The followed ball, while it flies. */
  get #ball() {
    return this.chosen === null ? undefined : this.game.room.table?.balls.get(this.chosen);
  }

  /** @param {Ball} ball */
  #follow(ball) {
    this.#release();
    this.chosen = ball.id;
    this.#start = ball.start;
    this.note.textContent = t("lab.followed", { seed: ball.seed });
  }

  #release() {
    this.chosen = null;
    this.#before = null;
    this.#series.clear();
    this.#shownCount = -1;
  }

  /** Follows the ball that started after the followed one, or else the oldest. */
  next() {
    const ball = this.#balls.find(({ id }) => id > (this.chosen ?? -1)) ?? this.#balls[0];
    if (ball) this.#follow(ball);
    else this.note.textContent = t("lab.no-ball");
  }

  /** Follows the ball nearest to a point, if it is close. @param {number} x m @param {number} y m */
  pick(x, y) {
    const off = (/** @type {Ball} */ { pose }) => Math.hypot(pose.x - x, pose.y - y);
    const [ball] = this.#balls.sort((one, two) => off(one) - off(two));
    if (ball && off(ball) < NEAR * (this.game.room.table?.board.ball.radius ?? 0)) this.#follow(ball);
  }

  /** Measures the new keyframes of the followed ball. */
  measure() {
    const { table } = this.game.room;
    const since = this.#before?.t ?? -1;
    for (const keyframe of this.#ball?.path.keyframes ?? []) {
      if (table && keyframe.vIn && keyframe.t > since) this.#add(table.board, keyframe);
    }
  }

  /** @param {Board} board @param {Keyframe} keyframe */
  #add(board, { t, y, vx, vy, angle }) {
    const before = this.#before;
    // Keyframes have no spin: it is computed from the change of the angle.
    const omega = before ? shortestTurn(before.angle, angle) / (t - before.t) : 0;
    this.#before = { t, angle };
    const { moving, turning, height } = energyOf(board, { y, vx, vy, omega });
    this.#series.add({ t: t - this.#start, speed: Math.hypot(vx, vy), height, moving, turning });
  }

  /**
   * Redraws the plots, at most once in REDRAW_MS.
   * @param {number} nowMs
   * @returns {boolean} whether there is more to redraw
   */
  show(nowMs) {
    // Without a followed ball in flight, our newest one is followed.
    const newest = this.#ball ? null : this.#balls.findLast(({ mine, landed }) => mine && !landed);
    if (newest && newest.id !== this.chosen) this.#follow(newest);
    if (this.#series.count === this.#shownCount) return false;
    if (nowMs - this.#shownMs < REDRAW_MS) return true;
    this.#shownMs = nowMs;
    this.#shownCount = this.#series.count;
    this.#plot();
    return false;
  }

  #plot() {
    const rows = /** @type {MeterRow[]} */ (this.#series.rows);
    const x = { from: 0, to: Math.max(1, rows.at(-1)?.t ?? 0), unit: "s" };
    const points = rows.map(({ t: since, speed }) => ({ x: since, y: speed }));
    const most = points.reduce((top, { y }) => Math.max(top, y), 1);
    this.speed.set({ x, y: { from: 0, to: most, unit: "m/s" }, series: [{ points, colour: "trayMark", width: 1.5 }] });
    const areas = energyAreas(rows);
    this.energy.set({ x, ...areas });
    const whole = areas.series[areas.series.length - 1].points;
    this.speed.canvas.setAttribute("aria-label", rows.length
      ? t("lab.speed", { now: figure(points[points.length - 1].y), most: figure(most) })
      : t("lab.speed-none"));
    this.energy.canvas.setAttribute("aria-label", rows.length
      ? t("lab.energy", { first: figure(whole[0].y), unit: areas.y.unit, now: figure(whole[whole.length - 1].y) })
      : t("lab.energy-none"));
  }
}
