// Shows the session: counters on the marquee, the list of last drops with their replay links.

import { byId, make } from "../util/dom.js";
import { replayLink } from "../net/drop-address.js";
import { amount, multiplier, plain, shortSeed, signed } from "../util/format.js";

/** @import { Played, Session } from "../model/session.js" */
/** @import { Theme } from "../paint/theme.js" */

/** Draws a session; call `show` after it has changed. */
export class Scoreboard {
  /**
   * @param {Session} session
   * @param {Theme} theme
   * @param {(seed: string) => void} onReuse a seed of the list is wanted again
   */
  constructor(session, theme, onReuse) {
    this.session = session;
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
    byId("drops").replaceChildren(...last.map((drop) => this.#row(drop)));
  }

  /** @param {Played} drop */
  #row(drop) {
    const paid = this.#paid(drop);
    const seed = make("button", { class: "seed", type: "button", title: `Use seed ${drop.seed}` });
    seed.setAttribute("aria-label", `Use seed ${drop.seed} again`);
    seed.append(shortSeed(drop.seed));
    seed.addEventListener("click", () => this.onReuse(drop.seed));
    const where = make("span", { class: "on" }, drop.x === null ? drop.name : `${drop.name}, practice`);
    if (drop.knocked) {
      // What others did to the ball is in no seed: there is nothing to replay alone.
      return make("li", {}, paid, seed, where, make("span", { class: "on" }, "knocked"));
    }
    const link = make("a", { class: "again", href: replayLink(drop) }, "Replay");
    link.setAttribute("aria-label", `Replay seed ${drop.seed} on ${drop.name}`);
    if (drop.practice) where.append(" · practice");
    return make("li", {}, paid, seed, where, link);
  }

  /** @param {Played} drop @returns {HTMLElement} its multiplier, or that it has none */
  #paid({ bin, score }) {
    if (bin === null) {
      const title = "The ball came to rest in no bin: the stake is back";
      return make("span", { class: "paid", title }, "void");
    }
    const paid = make("span", { class: "paid" }, multiplier(score));
    const { fill, ink } = this.theme.payout(score);
    Object.assign(paid.style, { background: fill, color: ink });
    return paid;
  }
}
