// The "Measure" panel: fit, returns, one ball, the line. Costs nothing while it is closed.

import { BallMeter } from "../../instruments/ball-meter.js";
import { FitMeter } from "../../instruments/fit-meter.js";
import { LineMeter } from "../../instruments/line-meter.js";
import { byId } from "../../util/dom.js";

/** @import { Table } from "../../model/table/table.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

/** All instruments of a table. */
export class InstrumentPanel {
  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.panel = byId("measure", HTMLDetailsElement);
    this.ball = new BallMeter(theme);
    this.line = new LineMeter();
    this.fit = new FitMeter((expected) => game.tell("expected", expected), (text) => game.say(text));
    this.panel.addEventListener("toggle", () => {
      if (this.open) this.fit.open();
      game.tell("picture", null);
    });
    byId("follow").addEventListener("click", () => {
      this.ball.next();
      game.tell("picture", null);
    });
    game.on("table", ({ hello, table }) => {
      this.ball.setTable(table);
      this.fit.setTable(hello);
    });
    game.on("odds", (odds) => this.fit.setRecord(odds, this.open));
    game.on("pong", (ms) => this.line.pong(ms));
    game.on("snapshot", () => this.ball.measure());
    game.on("room", () => {
      if (game.room.state === "live") this.line.wake();
      else this.line.rest(game.room);
    });
  }

  get open() {
    return this.panel.open;
  }

  /** The ball that lies there is followed from now on. @param {number} x m @param {number} y m */
  pick(x, y) {
    if (this.open) this.ball.pick(x, y);
  }

  /** @param {number[]} counts of the tray @param {number} nowMs @returns {boolean} whether there is more to show soon */
  show(counts, nowMs) {
    const { room } = this.game;
    if (!this.open || !room.table) return false;
    this.#followOwn(room.table);
    this.line.drawn();
    if (room.table.flying) this.line.read(room, nowMs);
    const more = this.ball.show(nowMs);
    return this.fit.show(counts, this.game.account.scores, nowMs) || more;
  }

  /** Our newest ball is followed as long as nobody chose another that still flies. @param {Table} table */
  #followOwn(table) {
    if (!this.ball.free) return;
    let newest = null;
    for (const ball of table.balls.values()) if (ball.mine && !ball.landed) newest = ball;
    if (newest && newest.id !== this.ball.chosen) this.ball.follow(newest);
  }
}
