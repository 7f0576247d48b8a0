// The panel "Measure": fit, returns, one ball. It costs nothing while it is closed.

import { byId, onClick } from "../../util/dom.js";
import { BallMeter } from "./ball.js";
import { FitMeter } from "./fit.js";

/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

/** All instruments of a room. */
export class InstrumentPanel {
  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.panel = byId("measure", HTMLDetailsElement);
    this.ball = new BallMeter(game, theme);
    this.fit = new FitMeter(game, this.panel);
    this.panel.addEventListener("toggle", () => game.tell("picture", null));
    onClick("follow", () => {
      this.ball.next();
      game.tell("picture", null);
    });
  }

  get open() {
    return this.panel.open;
  }

  /** Follows the ball at a point. @param {number} x m @param {number} y m */
  pick(x, y) {
    if (this.open) this.ball.pick(x, y);
  }

  /** @param {number[]} counts of the tray @param {number} nowMs @returns {boolean} whether to call it again soon */
  show(counts, nowMs) {
    if (!this.open || !this.game.room.table) return false;
    const more = this.ball.show(nowMs);
    return this.fit.show(counts, nowMs) || more;
  }
}
