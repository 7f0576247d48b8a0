// The last drops: the newest five as chips beside the board, and all of them as a list.

import { replayLink } from "../../net/drop-address.js";
import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { shortSeed, signed } from "../../util/format.js";
import { Prover } from "../fairness/proof.js";
import { paidMark } from "./company.js";

/** @import { Played } from "../../model/player/account.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const CHIPS = 5;
const RENEWED_MS = 200; // while balls rain

/** Both are views of the account. */
export class History {
  /** @type {Map<string, HTMLElement>} rows by what they show: one of them may show its proof */
  #rows = new Map();
  #newest = "";

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.theme = theme;
    this.prover = new Prover(game.solver);
    game.on("table", ({ hello }) => this.prover.know(hello.board_digest, hello.board));
    game.onCalm("account", RENEWED_MS, () => this.#show());
    theme.onChange(() => {
      this.#rows.clear();
      this.#show();
    });
    this.#show();
  }

  #show() {
    const { last } = this.game.account;
    byId("history-empty").hidden = last.length > 0;
    const keys = last.map((drop) => JSON.stringify(drop));
    const rows = last.map((drop, i) => this.#rows.get(keys[i]) ?? this.#row(drop));
    this.#rows = new Map(keys.map((key, i) => [key, rows[i]]));
    byId("drops").replaceChildren(...rows);
    const fresh = this.#newest !== "" && keys.length > 0 && keys[0] !== this.#newest;
    this.#newest = keys[0] ?? " ";
    const chips = last.slice(0, CHIPS).map((drop) => make("li", {}, this.#paid(drop)));
    chips[0]?.classList.toggle("fresh", fresh);
    byId("last").replaceChildren(...chips);
  }

  /** @param {Played} drop */
  #row(drop) {
    const { seed, name, practice, stake, paid } = drop;
    const where = practice || drop.x !== null
      ? make("span", { class: "on" }, t("practice.word"))
      : make("span", { class: "on" }, make("b", {}, signed(paid - stake)), ` ${name}`);
    const row = make("li", {}, this.#paid(drop), where);
    if (drop.knocked) {
      // What others did to the ball is in no seed: there is nothing to replay alone.
      row.append(make("span", { class: "on" }, t("play.knocked")));
      return row;
    }
    if (this.prover.canVerify(drop)) {
      row.append(this.#key("play.verify", t("play.verify-seed", { seed, board: name }), () => this.prover.show(drop, row)));
    }
    const link = make("a", { class: "again", href: replayLink(drop) }, t("play.replay"));
    link.setAttribute("aria-label", t("play.replay-seed", { seed, board: name }));
    const use = t("play.use-seed-again", { seed: shortSeed(seed) });
    row.append(link, this.#key("play.use-seed", use, () => this.#use(seed)));
    return row;
  }

  /** @param {"play.verify" | "play.use-seed"} text @param {string} name @param {() => void} press */
  #key(text, name, press) {
    const button = make("button", { class: "verify", type: "button", "aria-label": name, title: name }, t(text));
    button.addEventListener("click", press);
    return button;
  }

  /** Practice with the seed of a drop. @param {string} seed */
  #use(seed) {
    const field = byId("seed", HTMLInputElement);
    field.value = seed;
    field.dispatchEvent(new Event("input"));
  }

  /** @param {Played} drop @returns {HTMLElement} its multiplier, or that it has none */
  #paid({ bin, score }) {
    const paid = paidMark(this.theme, null, bin, score);
    if (bin === null) paid.title = t("play.void-why");
    return paid;
  }
}
