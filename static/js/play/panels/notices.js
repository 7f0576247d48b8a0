// What the page says: the line of results, the state of the connection, and a way on where a table is gone.

import { Falling } from "../show/falling.js";
import { MAIN_ROOM } from "../../model/presets.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";
import { putIntoAddress } from "../rooms.js";

/** @import { Scene } from "../../model/scene.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

/** The status line: results at once, words on the way of a ball between them. */
export class Notices {
  #falling = new Falling();
  #state = "connecting";

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.theme = theme;
    this.line = byId("result");
    game.on("said", ({ text, score, urgent = false }) => this.#say(text, score, urgent));
    game.on("table", ({ table }) => this.#falling.setBoard(table.board));
    game.on("room", () => this.#showState());
    byId("gone-key").addEventListener("click", () => this.#wayOn());
    byId("line-key").addEventListener("click", () => game.room.connection.retryNow());
    this.#showState();
  }

  /** How far our only ball has come, or how many fall. @param {Scene} scene */
  watch({ balls }) {
    const { falling } = this.game;
    if (falling === 0) return;
    const words = falling > 1 ? t("play.balls-fall", { n: falling }) : this.#falling.words(balls);
    if (words && !this.#falling.silent && this.line.textContent !== words) this.#put(words);
  }

  /** @param {string} text @param {number | undefined} score @param {boolean} urgent */
  #say(text, score, urgent) {
    this.#falling.silent = urgent && this.game.busy;
    this.#put(text, score);
  }

  /** @param {string} text @param {number} [score] */
  #put(text, score) {
    this.line.textContent = text;
    this.line.style.setProperty("--paid", score === undefined ? "transparent" : this.theme.payout(score).fill);
  }

  #showState() {
    const { state, wait, hello } = this.game.room;
    const { dataset } = document.documentElement;
    dataset.state = state;
    byId("state-text").textContent = state === "reconnecting" ? t("play.reconnecting", { n: wait }) : STATES[state]();
    byId("gone").hidden = state !== "closed";
    byId("gone-words").textContent = state === "closed" ? t(hello ? "play.table-closed" : "play.table-gone") : "";
    byId("line-key").hidden = state !== "reconnecting";
    if (state === "reconnecting" && this.#state !== state) this.#say(t("play.line-broke"), undefined, true);
    if (this.#state === "reconnecting" && (state === "live" || state === "asleep")) {
      this.#say(t("play.back"), undefined, true);
    }
    this.#state = state;
  }

  /** From a table that is gone to the main one. */
  #wayOn() {
    putIntoAddress(MAIN_ROOM);
    if (this.game.room.id === MAIN_ROOM) window.location.reload();
    else this.game.enter(MAIN_ROOM);
  }
}

/** @type {Record<import("../room.js").LineState, () => string>} */
const STATES = {
  connecting: () => t("play.connecting"),
  live: () => t("play.live"),
  asleep: () => t("play.ready"),
  closed: () => t("play.closed"),
  reconnecting: () => "",
};
