// What a table shows beyond its balls: where balls have passed, what a landing leaves on the board, and wins. A page
// loads it with the first ball.

import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { Celebration, WIN } from "./celebration.js";
import { Ghost } from "./ghost.js";
import { LandingZoom } from "./landing-zoom.js";
import { Streaks } from "./streaks.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Board, Point } from "../../model/board.js" */
/** @import { Hello } from "../../model/messages.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Solved } from "../../model/table/path-feed.js" */
/** @import { Table } from "../../model/table/table.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const GHOST_KEY = "plinko.ghost.1";
const NEAR = 0.5; // ball radii from the ball's centre to the edge between the bins
const MORE = 3; // the better bin pays at least this many times as much, and
const LEAST = 2; // at least this multiplier

/** The effects on one board. */
export class Show {
  #digest = "";
  /** A win to celebrate after the zoom. @type {Played | null} */
  #won = null;
  #landingZoom = new LandingZoom();
  #streaks = new Streaks();

  /** @param {Game} game @param {Theme} theme @param {BoardView} view @param {MediaQueryList} still whether motion is reduced */
  constructor(game, theme, view, still) {
    this.game = game;
    this.view = view;
    this.still = still;
    this.ghost = new Ghost(byId("board-ghost", HTMLCanvasElement), theme);
    this.ghost.on = game.storage.getItem(GHOST_KEY) !== "off";
    this.celebration = new Celebration(theme, view);
    game.on("table", ({ hello, table }) => this.#setTable(hello, table));
    let falling = 0;
    game.on("run", () => {
      // Our next ball clears what is shown of the last landing. An auto-drop leaves a win's card its time.
      if (game.falling > falling && !game.auto) this.celebration.hide();
      if (game.falling > falling && !this.#landingZoom.looking) this.#landingZoom.clear();
      falling = game.falling;
    });
    theme.onChange(() => this.ghost.recolour());
  }

  /** Shows or hides where balls have passed, from now on. @param {boolean} on */
  setGhost(on) {
    this.ghost.on = on;
    this.game.storage.setItem(GHOST_KEY, on ? "on" : "off");
    this.game.tell("picture", null);
  }

  /** Follows a change of the board's size. */
  layOut() {
    if (this.view.geometry) this.ghost.layOut(this.view.geometry);
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable({ board, board_digest: digest }, table) {
    // After a reconnect the board is usually the same.
    if (this.#digest !== digest) {
      this.#digest = digest;
      this.ghost.setBoard(board);
      this.layOut();
    }
    this.#streaks.clear();
    this.#landingZoom.clear();
    this.celebration.hide();
    this.#won = null;
    table.onPassed = this.ghost.follow;
  }

  /** Our drop's landing was shown. @param {Played} played */
  see(played) {
    const { bin, score } = played;
    const { game } = this;
    const still = this.still.matches;
    const looked = document.visibilityState !== "hidden";
    const last = looked && game.room.own.unseen === 0 && !game.auto;
    const drop = this.#solve(played);
    const { board, solve } = game.room.table ?? {};
    if (drop && game.choice.pace === "instant" && !still) this.#streaks.add(drop);
    const won = looked && bin !== null && score >= WIN;
    if (drop && board && solve && bin !== null && (last || won) && !this.#landingZoom.looking) {
      this.#landingZoom.begin(drop, board, (x) => solve({ seed: "0", x }), still);
    }
    if (won && (!this.#won || score > this.#won.score)) this.#won = played;
    if (last && drop && board && bin !== null && !won) {
      // How close the ball came to a better bin stands next to its payout.
      byId("near").textContent = nearMiss(board, bin, drop.xEnd);
      byId("near").hidden = byId("near").textContent === "";
    }
    game.tell("picture", null);
  }

  /** @param {Played} played @returns {Solved | null} null if this page cannot compute it */
  #solve({ seed, x, aim, knocked }) {
    const { table } = this.game.room;
    if (knocked || !table?.solve) return null;
    return table.solve(x === null ? { seed, aim: aim ?? undefined } : { seed, x });
  }

  /**
   * Adds to a scene what lies between and over the balls.
   * @param {Scene} scene @param {number} now ms
   * @returns {boolean} whether anything moves
   */
  dress(scene, now) {
    const still = this.still.matches;
    const lab = document.documentElement.dataset.drawer === "lab";
    const streaking = this.#streaks.show(scene, now / 1000);
    const zooming = this.#landingZoom.show(scene, now / 1000, still, lab);
    this.#look(this.#landingZoom.near);
    if (this.#won && !this.#landingZoom.looking) {
      this.celebration.celebrate(this.#won, still);
      this.#won = null;
    }
    this.ghost.paint(now);
    const celebrating = this.celebration.show(now);
    return streaking || zooming || celebrating || this.#won !== null || this.ghost.pending;
  }

  /** Zooms in on a point of the board, or out again. @param {Point | null} place m; null zooms out */
  #look(place) {
    const { geometry, box } = this.view;
    box.classList.toggle("near", place !== null);
    if (!place || !geometry) return;
    box.style.setProperty("--near-x", `${geometry.px(place.x)}px`);
    box.style.setProperty("--near-y", `${geometry.py(place.y)}px`);
  }
}

/**
 * How close our ball came to a better bin, in words.
 * @param {Pick<Board, "ball" | "bins">} board
 * @param {number} bin in which the ball landed
 * @param {number} x where its centre crossed the bins' line, m
 * @returns {string} a sentence, or ""
 */
export function nearMiss({ ball, bins }, bin, x) {
  const { edges, multipliers } = bins;
  const sides = [
    { other: bin - 1, away: x - edges[bin] },
    { other: bin + 1, away: edges[bin + 1] - x },
  ];
  const near = sides.filter(({ other, away }) => away >= 0 && away < NEAR * ball.radius
    && multipliers[other] >= Math.max(LEAST, MORE * multipliers[bin]));
  if (near.length === 0) return "";
  const [{ other }] = near;
  return t("play.near", { pays: prizeOf({ bins }, other, multipliers[other]) });
}
