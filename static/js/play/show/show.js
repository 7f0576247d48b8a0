// What there is to a drop besides its path: words on the way, what decided it, light, one line for many.

import { Announcer } from "./announcer.js";
import { Card } from "./card.js";
import { Encore } from "./encore.js";
import { Falling } from "./falling.js";
import { nearMiss } from "./near-miss.js";

/** @import { Scene } from "../../model/scene.js" */
/** @import { Played } from "../../model/player/session.js" */
/** @import { Solved } from "../../model/table/solved-feed.js" */
/** @import { Table } from "../../model/table/table.js" */

/** Of one table at a time. */
export class Show {
  #card = new Card();
  #encore = new Encore();
  #falling = new Falling();
  /** @type {Table | null} */
  #table = null;

  /** @param {(text: string, score?: number) => void} say */
  constructor(say) {
    this.say = say;
    this.announcer = new Announcer(say);
  }

  /** @param {Table} table */
  setTable(table) {
    this.#table = table;
    this.#falling.setBoard(table.board);
    this.dropped();
  }

  /** A ball of ours is asked for: what was shown of the one before is over. */
  dropped() {
    this.#encore.clear();
    this.#card.hide();
  }

  /**
   * @param {Played} played
   * @param {{last: boolean, still: boolean}} now last: somebody looks, and no other ball of ours is in
   *   flight; still: nothing is to move
   */
  played(played, { last, still }) {
    this.#card.show(played, still);
    const drop = this.#solve(played);
    const { bin } = played;
    const near = drop && this.#table && bin !== null ? nearMiss(this.#table.board, bin, drop.xEnd) : "";
    this.announcer.add({ ...played, near });
    if (drop && last && bin !== null) this.#begin(drop);
  }

  /** @param {Solved} drop */
  #begin(drop) {
    const { board, solve } = this.#table ?? {};
    if (board && solve) this.#encore.begin(drop, board, (x) => solve({ seed: "0", x }));
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
    const counting = this.#card.count(1000 * wall);
    return this.#encore.show(scene, wall, still) || counting;
  }
}
