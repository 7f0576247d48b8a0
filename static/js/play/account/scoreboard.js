// Shows the session: counters on the marquee, the list of last drops with their replay links.

import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { replayLink } from "../../net/drop-address.js";
import { amount, multiplier, plain, shortSeed, signed } from "../../util/format.js";

/** @import { Played, Session } from "../../model/player/session.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Prover } from "../fairness/proof.js" */

/** Draws a session; call `show` after it has changed. */
export class Scoreboard {
  /** @type {Map<Played, HTMLElement>} */
  #rows = new Map();

  /**
   * @param {Session} session
   * @param {Theme} theme
   * @param {Prover} prover
   * @param {(seed: string) => void} onReuse a seed of the list is wanted again
   */
  constructor(session, theme, prover, onReuse) {
    this.session = session;
    this.prover = prover;
    this.theme = theme;
    this.onReuse = onReuse;
    byId("history-clear").addEventListener("click", () => {
      session.clear();
      this.show();
    });
    this.show();
  }

  show() {
    const { staked, returned, net, last } = this.session;
    byId("staked").textContent = plain(staked);
    byId("returned").textContent = amount(returned);
    byId("net").textContent = signed(net);
    byId("net").dataset.sign = String(Math.sign(Math.round(net * 100)));
    byId("history-empty").hidden = last.length > 0;
    byId("history-clear").hidden = last.length === 0;
    // Rows that are there stay: one of them may show its proof.
    const rows = last.map((drop) => this.#rows.get(drop) ?? this.#row(drop));
    this.#rows = new Map(last.map((drop, i) => [drop, rows[i]]));
    byId("drops").replaceChildren(...rows);
  }

  /** @param {Played} drop */
  #row(drop) {
    const paid = this.#paid(drop);
    const seed = make("button", { class: "seed", type: "button", title: t("play.use-seed", { seed: drop.seed }) });
    seed.setAttribute("aria-label", t("play.use-seed-again", { seed: drop.seed }));
    seed.append(shortSeed(drop.seed));
    seed.addEventListener("click", () => this.onReuse(drop.seed));
    const practice = drop.practice || drop.x !== null;
    const where = practice
      ? make("span", { class: "on" }, t("play.practice"))
      : make("span", { class: "on board-name" }, drop.name);
    if (drop.knocked) {
      // What others did to the ball is in no seed: there is nothing to replay alone.
      return make("li", {}, paid, seed, where, make("span", { class: "on" }, t("play.knocked")));
    }
    const link = make("a", { class: "again", href: replayLink(drop) }, t("play.replay"));
    link.setAttribute("aria-label", t("play.replay-seed", { seed: drop.seed, board: drop.name }));
    const row = make("li", {}, paid, seed, where, link);
    if (this.prover.canVerify(drop)) link.before(this.#verifyButton(drop, row));
    return row;
  }

  /** @param {Played} drop @param {HTMLElement} row */
  #verifyButton(drop, row) {
    const button = make("button", { class: "verify", type: "button" }, t("play.verify"));
    button.setAttribute("aria-label", t("play.verify-seed", { seed: drop.seed, board: drop.name }));
    button.addEventListener("click", () => this.prover.show(drop, row));
    return button;
  }

  /** Colours have changed: every row is made anew. */
  recolour() {
    this.#rows.clear();
    this.show();
  }

  /** @param {Played} drop @returns {HTMLElement} its multiplier, or that it has none */
  #paid({ bin, score }) {
    if (bin === null) {
      const title = t("play.void-why");
      return make("span", { class: "paid", title }, t("play.void"));
    }
    const paid = make("span", { class: "paid" }, multiplier(score));
    const { fill, ink } = this.theme.payout(score);
    Object.assign(paid.style, { background: fill, color: ink });
    return paid;
  }
}
