// The card of a large win: what it paid, counted up, and the way to share the ball.

import { replayLink } from "../../net/drop-address.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { amount, multiplier, plain } from "../../util/format.js";

/** @import { Played } from "../../model/player/session.js" */

const LEAST = 100; // times the stake
const COUNT_MS = 1800;

/** @param {Played} played @returns {boolean} whether it is worth a card */
export function isLarge({ score, bin }) {
  return score >= LEAST && bin !== null;
}

/** Lies over the board until the next ball falls, or until it is put away. */
export class Card {
  /** @type {{score: number, since: number | null} | null} */
  #counting = null;

  constructor() {
    this.box = byId("card");
    this.score = byId("card-score");
    byId("card-close").addEventListener("click", () => this.hide());
  }

  /** Whether it still counts up. */
  get counting() {
    return this.#counting !== null;
  }

  hide() {
    this.#counting = null;
    this.box.hidden = true;
  }

  /** @param {Played} played a large win @param {boolean} still nothing is to move */
  show(played, still) {
    const { score, stake = 1, practice } = played;
    byId("card-words").textContent = practice
      ? t("play.win-practice")
      : t("play.win-paid", { paid: amount(stake * score), stake: plain(stake) });
    byId("card-share", HTMLAnchorElement).href = replayLink(played);
    this.#counting = { score, since: null };
    this.box.hidden = false;
    this.score.textContent = multiplier(still ? score : 0);
    if (still) this.#counting = null;
  }

  /** Counts up. @param {number} nowMs @returns {boolean} whether it goes on */
  count(nowMs) {
    const counting = this.#counting;
    if (!counting) return false;
    counting.since ??= nowMs;
    const part = Math.min(1, (nowMs - counting.since) / COUNT_MS);
    const shown = part === 1 ? counting.score : Math.floor(counting.score * (1 - (1 - part) ** 3));
    this.score.textContent = multiplier(shown);
    if (part === 1) this.#counting = null;
    return part < 1;
  }
}
