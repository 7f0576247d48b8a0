// Follows one ball: its speed and energy against time, from the moments known of its path.

import { energyOf } from "../model/impact.js";
import { shortestTurn } from "../model/motion/interpolate.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { figure } from "../util/scale.js";
import { Series } from "../util/series.js";
import { Chart } from "./chart.js";
import { energyAreas } from "./energy-areas.js";

/** @import { Ball, Table } from "../model/table/table.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Keyframe } from "../model/motion/interpolate.js" */
/** @import { Board } from "../model/board.js" */
/** @import { EnergyRow } from "./energy-areas.js" */

/** @typedef {EnergyRow & {speed: number}} MeterRow */

const REDRAW_MS = 200;
const NEAR = 3; // of the ball's radius: how far a click may miss it

/** The chosen ball of a table, and its two plots. */
export class BallMeter {
  /** @type {number | null} id of the ball that is followed */
  chosen = null;
  /** @type {Table | null} */
  #table = null;
  /** When the followed ball started, table time. */
  #start = 0;
  #series = new Series(["t", "speed", "height", "moving", "turning"]);
  /** @type {{t: number, angle: number} | null} */
  #before = null;
  #shownMs = 0;
  #shownCount = -1;

  /** @param {Theme} theme */
  constructor(theme) {
    this.speed = new Chart(byId("speed-plot", HTMLCanvasElement), theme);
    this.energy = new Chart(byId("energy-plot", HTMLCanvasElement), theme);
    this.note = byId("ball-note");
  }

  /** @param {Table} table another one: what was followed is gone */
  setTable(table) {
    this.#table = table;
    this.#release();
  }

  /** @returns {boolean} whether nothing that still flies is followed */
  get free() {
    return this.chosen === null || !this.#table?.balls.has(this.chosen);
  }

  /** @param {Ball} ball */
  follow(ball) {
    this.#release();
    this.chosen = ball.id;
    this.#start = ball.start;
    this.note.textContent = t("lab.followed", { seed: ball.seed });
  }

  /** The ball that started after the followed one, or the oldest. */
  next() {
    const balls = [...(this.#table?.balls.values() ?? [])];
    const ball = balls.find(({ id }) => id > (this.chosen ?? -1)) ?? balls[0];
    if (ball) this.follow(ball);
    else this.note.textContent = t("lab.no-ball");
  }

  /** @param {number} x metres @param {number} y metres @returns {boolean} whether a ball is there */
  pick(x, y) {
    if (!this.#table) return false;
    let best = NEAR * this.#table.board.ball.radius;
    let found = null;
    for (const ball of this.#table.balls.values()) {
      const off = Math.hypot(ball.pose.x - x, ball.pose.y - y);
      if (off < best) [best, found] = [off, ball];
    }
    if (found) this.follow(found);
    return found !== null;
  }

  /** The followed ball's path has grown: its new moments are measured. */
  measure() {
    const ball = this.chosen === null ? undefined : this.#table?.balls.get(this.chosen);
    if (!this.#table || !ball) return;
    const since = this.#before?.t ?? -1;
    for (const keyframe of ball.path.keyframes) {
      if (keyframe.vIn && keyframe.t > since) this.#add(this.#table.board, keyframe);
    }
  }

  /** @param {Board} board @param {Keyframe} keyframe */
  #add(board, { t, y, vx, vy, angle }) {
    const before = this.#before;
    // The wire has no spin; the angle's change since the last snapshot has it.
    const omega = before ? shortestTurn(before.angle, angle) / (t - before.t) : 0;
    this.#before = { t, angle };
    const { moving, turning, height } = energyOf(board, { y, vx, vy, omega });
    this.#series.add({ t: t - this.#start, speed: Math.hypot(vx, vy), height, moving, turning });
  }

  /**
   * Redraws the plots now and then.
   * @param {number} nowMs
   * @returns {boolean} whether there is more to redraw
   */
  show(nowMs) {
    if (this.#series.count === this.#shownCount) return false;
    if (nowMs - this.#shownMs < REDRAW_MS) return true;
    this.#shownMs = nowMs;
    this.#shownCount = this.#series.count;
    this.#plot();
    return false;
  }

  #release() {
    this.chosen = null;
    this.#before = null;
    this.#series.clear();
    this.#shownCount = -1;
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
