// The tray below the board: bars or the pile, what is expected there, and how many have landed.

import { Histogram } from "../../instruments/histogram.js";
import { openPile } from "../../instruments/pile/pile.js";
import { t } from "../../texts/text.js";
import { byId, onClick } from "../../util/dom.js";

/** @import { Expected } from "./fit.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const PILE_KEY = "plinko.pile.1";
const RENEWED_MS = 200;

/** The pile is what is shown unless the player chose bars; what moves it is fetched at the first touch. */
export class Tray {
  #shown = "";
  #shownMs = 0;
  #pile;
  #fetched = false;
  /** @type {Expected | null} */
  #expected = null;

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.theme = theme;
    this.histogram = new Histogram(byId("histogram", HTMLCanvasElement), theme);
    this.#pile = game.storage.getItem(PILE_KEY) !== "off";
    this.button = byId("pile");
    this.button.setAttribute("aria-pressed", String(this.#pile));
    onClick("pile", () => {
      this.#pile = !this.#pile;
      game.storage.setItem(PILE_KEY, this.#pile ? "on" : "off");
      void this.#fetch();
    });
    game.on("hit", ({ bin, entry }) => {
      this.histogram.add(bin, entry);
      game.tell("picture", null);
    });
    const first = () => { if (!this.#fetched) void this.#fetch(); };
    for (const gesture of ["pointermove", "pointerdown", "keydown"]) document.addEventListener(gesture, first, { once: true });
    game.on("run", first);
    game.on("expected", (expected) => {
      this.#expected = expected;
      this.histogram.setExpected(expected);
      game.tell("picture", null);
    });
    theme.onChange(() => this.histogram.draw());
  }

  async #fetch() {
    this.#fetched = true;
    const wanted = this.#pile;
    this.button.setAttribute("aria-pressed", String(wanted));
    try {
      const pile = wanted ? await openPile(this.theme) : null;
      if (wanted === this.#pile) this.histogram.setPile(pile);
    } catch {
      this.#pile = false;
      this.button.setAttribute("aria-pressed", "false");
      this.game.say(t("play.pile-fails"), { urgent: true });
    }
    this.game.tell("picture", null);
  }

  /** @param {number} nowMs @param {boolean} still nothing is to move @returns {boolean} whether there is more to show soon */
  show(nowMs, still) {
    this.histogram.refresh(nowMs, still);
    const { total, share } = this.histogram;
    const words = share !== null && share > 1 ? "play.landed-as-discs" : "play.landed-here";
    const text = total ? t(words, { n: total, share: share ?? 1 }) : t("play.none-landed");
    const due = text !== this.#shown;
    if (due && nowMs - this.#shownMs >= RENEWED_MS) {
      this.#shown = text;
      this.#shownMs = nowMs;
      byId("tray-count").textContent = text;
    }
    byId("tray-key").hidden = !this.#expected;
    return due || this.histogram.pending;
  }
}
