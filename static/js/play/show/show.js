// What there is to a drop besides its path: words on the way, what decided it, light, one line for many.

import { Announcer } from "./announcer.js";
import { Card, isLarge } from "./card.js";
import { Encore } from "./encore.js";
import { Falling } from "./falling.js";
import { HandOn } from "./hand-on.js";
import { nearMiss } from "./near-miss.js";
import { Streaks } from "./streaks.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Point } from "../../model/board.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Played } from "../../model/player/session.js" */
/** @import { Solved } from "../../model/table/solved-feed.js" */
/** @import { Table } from "../../model/table/table.js" */

/** Of one table at a time. */
export class Show {
  #card = new Card();
  #encore = new Encore();
  #falling = new Falling();
  #streaks = new Streaks();
  /** @type {Table | null} */
  #table = null;

  /** A large win whose card is still to be shown. @type {{played: Played, still: boolean} | null} */
  #won = null;

  /** @param {BoardView} view @param {(text: string, score?: number) => void} say */
  constructor(view, say) {
    this.view = view;
    this.say = say;
    this.announcer = new Announcer(say);
    this.handOn = new HandOn(say);
  }

  /** How far a ball has come is not said over what is more urgent. @param {boolean} silent */
  hush(silent) {
    this.#falling.silent = silent;
  }

  /** @param {Table} table */
  setTable(table) {
    this.#table = table;
    this.#falling.setBoard(table.board);
    this.#streaks.clear();
    this.#encore.clear();
    this.#card.hide();
    this.handOn.hide();
    this.#won = null;
  }

  /** A ball of ours is asked for: what was shown of the one before is over, but for a large win's moment. */
  dropped() {
    this.handOn.hide();
    if (this.#encore.looking || this.#card.counting) return;
    this.#encore.clear();
    this.#card.hide();
  }

  /**
   * @param {Played} played
   * @param {{last: boolean, still: boolean, atOnce: boolean}} now last: somebody looks, and no other ball of ours is
   *   in flight; still: nothing is to move; atOnce: nobody saw it fall
   */
  played(played, { last, still, atOnce }) {
    const drop = this.#solve(played);
    const { bin } = played;
    const near = drop && this.#table && bin !== null ? nearMiss(this.#table.board, bin, drop.xEnd) : "";
    this.announcer.add({ ...played, near });
    if (drop && atOnce && !still) this.#streaks.add(drop);
    // A large win has its moment, whatever else falls.
    const large = isLarge(played);
    if (drop && bin !== null && (last || large) && !this.#encore.looking) this.#begin(drop, still);
    if (large) this.#won = { played, still };
    if (last) this.handOn.offer(played);
  }

  /** @param {Solved} drop @param {boolean} still */
  #begin(drop, still) {
    const { board, solve } = this.#table ?? {};
    if (board && solve) this.#encore.begin(drop, board, (x) => solve({ seed: "0", x }), still);
  }

  /** @param {Played} played @returns {Solved | null} where this page computes what became of it */
  #solve({ seed, x, aim, knocked }) {
    if (knocked || !this.#table?.solve) return null;
    return this.#table.solve(x === null ? { seed, aim: aim ?? undefined } : { seed, x });
  }

  /**
   * Adds to a scene what there is to see, and says how far a ball has come.
   * @param {Scene} scene @param {number} wall local time, s @param {boolean} still nothing is to move
   * @returns {boolean} whether it goes on moving
   */
  show(scene, wall, still) {
    const words = this.announcer.counts ? null : this.#falling.words(scene.balls);
    if (words) this.say(words);
    scene.fork = null;
    const streaking = this.#streaks.show(scene, wall);
    const moving = this.#encore.show(scene, wall, still);
    this.#look(this.#encore.near);
    if (this.#won && !this.#encore.looking) {
      this.#card.show(this.#won.played, this.#won.still);
      this.#won = null;
    }
    const counting = this.#card.count(1000 * wall);
    return moving || counting || streaking || this.#won !== null;
  }

  /** Brings the board near to a place, or back. @param {Point | null} place m */
  #look(place) {
    const { geometry } = this.view;
    this.view.box.classList.toggle("near", place !== null);
    if (!place || !geometry) return;
    const { style } = this.view.box;
    style.setProperty("--near-x", `${geometry.px(place.x)}px`);
    style.setProperty("--near-y", `${geometry.py(place.y)}px`);
  }
}
