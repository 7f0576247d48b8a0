// The "Measure" panel: fit, returns, one ball, the line. Costs nothing while it is closed.

import { BallMeter } from "./ball-meter.js";
import { byId } from "../util/dom.js";
import { FitMeter } from "./fit-meter.js";
import { LineMeter } from "./line-meter.js";

const WIDE = "(min-width: 84rem)"; // as in gauges.css: it has a column of its own

/**
 * @typedef {object} MeasuresListener
 * @property {(expected: import("./fit-meter.js").Expected | null) => void} onExpected
 * @property {() => void} onChange there is something to show
 * @property {(text: string) => void} say
 */

/** All instruments of a table. */
export class Measures {
  /** @param {import("../paint/theme.js").Theme} theme @param {MeasuresListener} listener */
  constructor(theme, { onExpected, onChange, say }) {
    this.panel = byId("measure");
    this.panel.open = window.matchMedia(WIDE).matches;
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

  /** @param {any} hello @param {import("../model/table/table.js").Table} table */
  setTable(hello, table) {
    this.ball.setTable(table);
    this.fit.setTable(hello, this.open);
  }

  /** @returns {boolean} whether a ball lies there: it is followed from now on */
  pick(x, y) {
    return this.open && this.ball.pick(x, y);
  }

  /** @returns {boolean} whether there is more to show soon */
  show(live, counts, scores, nowMs) {
    if (!this.open || !live.table) return false;
    this.#followOwn(live.table);
    this.line.frame();
    if (live.table.flying) this.line.read(live, nowMs);
    const more = this.ball.show(nowMs);
    return this.fit.show(counts, scores, nowMs) || more;
  }

  /** Our newest ball is followed as long as nobody chose another that still flies. */
  #followOwn(table) {
    if (!this.ball.free) return;
    let newest = null;
    for (const ball of table.balls.values()) if (ball.mine && !ball.landed) newest = ball;
    if (newest && newest.id !== this.ball.chosen) this.ball.follow(newest);
  }
}
