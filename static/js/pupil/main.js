// A pupil's phone: a button that drops a ball on the class's board, and where the own balls landed.

import { openPage, showState } from "../board/page.js";
import { ApiError } from "../net/api.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId, onClick } from "../util/dom.js";
import { fixed } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { TrialView } from "../class/trial-view.js";
import { joinRoom } from "../class/phones.js";
import { summaryOf } from "../class/statistics.js";
import { Trial } from "../class/trial.js";

/** @import { Connection } from "../net/connection.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Hello } from "../model/messages.js" */

class PupilPage {
  /** @type {Trial | null} */
  trial = null;
  #ref = 0;
  #shown = -1;
  #board = "";
  #own = new Set();
  #calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  /** @param {Theme} theme @param {Solver} solver @param {string} room */
  constructor(theme, solver, room) {
    this.solver = solver;
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.view = new TrialView("trial-0", theme, () => this.loop.wake());
    theme.onChange(() => this.loop.wake());
    const who = crypto.randomUUID();
    /** @type {Connection} */
    this.connection = joinRoom(room, { who }, {
      onHello: (hello) => this.#begin(hello),
      onBall: ({ ref, seed, x }) => {
        if (!this.#own.delete(ref)) return;
        this.trial?.enter(seed, x ?? null, false);
        this.loop.wake();
      },
      onHere: () => {},
      onTrouble: (text) => {
        byId("result").textContent = text;
      },
    });
    onClick("drop", () => {
      this.#ref += 1;
      this.#own.add(`${this.#ref}`);
      if (!this.connection.send({ type: "drop", ref: `${this.#ref}` })) byId("result").textContent = t("stage.lost");
    });
  }

  /** @param {Hello} hello after a lost connection the board is the same, and the own balls stay */
  #begin({ board }) {
    showState("live", t("play.ready"));
    byId("drop", HTMLButtonElement).disabled = false;
    const rows = board.bins.multipliers.length - 1;
    const text = JSON.stringify(board);
    if (text === this.#board) return;
    this.#board = text;
    this.trial = new Trial(this.solver, { rows, p: 0.5, restitution: 0, gravity: board.gravity }, 0, board);
    this.trial.calm = this.#calm.matches;
    this.#shown = -1;
    this.loop.wake();
  }

  /** @param {number} now ms */
  #draw(now) {
    const { trial } = this;
    if (!trial) return false;
    const moves = trial.advance(now);
    this.view.draw(trial, now, { all: true, guess: null, secret: false, cursor: null, plain: true });
    const { counts, bins } = trial.over(true);
    if (bins.length !== this.#shown) {
      this.#shown = bins.length;
      const { n, mean } = summaryOf(counts);
      byId("result").textContent = n
        ? t("class.own", { n, last: bins[n - 1], rows: counts.length - 1, mean: fixed(mean, 1) }) : t("class.press");
    }
    return moves;
  }
}

openPage(async (theme) => {
  const room = new URLSearchParams(window.location.search).get("room");
  if (!room) throw new ApiError(t("class.closed"), 0);
  new PupilPage(theme, await openSolver(), room);
});
