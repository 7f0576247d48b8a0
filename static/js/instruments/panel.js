// The "Measure" panel: fit, returns, one ball, the line. Costs nothing while it is closed.

import { byId } from "../util/dom.js";
import { BallMeter } from "./ball-meter.js";
import { FitMeter } from "./fit-meter.js";
import { LineMeter } from "./line-meter.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Table } from "../model/table/table.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Expected } from "./fit-meter.js" */
/** @import { Mean } from "../model/statistics.js" */
/** @import { Line } from "./line-meter.js" */

/**
 * @typedef {object} PanelListener
 * @property {(expected: Expected | null) => void} onExpected
 * @property {() => void} onChange there is something to show
 * @property {(text: string) => void} say
 */

/** All instruments of a table. */
export class InstrumentPanel {
  /** @param {Theme} theme @param {PanelListener} listener */
  constructor(theme, { onExpected, onChange, say }) {
    this.panel = byId("measure", HTMLDetailsElement);
    this.ball = new BallMeter(theme);
    this.line = new LineMeter();
    this.fit = new FitMeter(onExpected, say);
    this.panel.addEventListener("toggle", () => {
      if (this.open) this.fit.open();
      onChange();
    });
    byId("follow").addEventListener("click", () => {
      this.ball.next();
      onChange();
    });
  }

  get open() {
    return this.panel.open;
  }

  /** @param {Hello} hello @param {Table} table */
  setTable(hello, table) {
    this.ball.setTable(table);
    this.fit.setTable(hello);
  }

  /**
   * @param {number} x
   * @param {number} y
   * @returns {boolean} whether a ball lies there: it is followed from now on
   */
  pick(x, y) {
    return this.open && this.ball.pick(x, y);
  }

  /**
   * @param {Line & {table: Table | null}} live
   * @param {number[]} counts
   * @param {Mean} scores
   * @param {number} nowMs
   * @returns {boolean} whether there is more to show soon
   */
  show(live, counts, scores, nowMs) {
    if (!this.open || !live.table) return false;
    this.#followOwn(live.table);
    this.line.drawn();
    if (live.table.flying) this.line.read(live, nowMs);
    const more = this.ball.show(nowMs);
    return this.fit.show(counts, scores, nowMs) || more;
  }

  /**
   * Our newest ball is followed as long as nobody chose another that still flies.
   * @param {Table} table
   */
  #followOwn(table) {
    if (!this.ball.free) return;
    let newest = null;
    for (const ball of table.balls.values()) if (ball.mine && !ball.landed) newest = ball;
    if (newest && newest.id !== this.ball.chosen) this.ball.follow(newest);
  }
}
