// Who is at the table, what they have just won, one's own name and colour, and a link that invites.

import { labelOf } from "../../model/board.js";
import { swatchOf } from "../../model/table/company.js";
import { COLOURS } from "../../model/player/colour.js";
import { replayLink } from "../../net/drop-address.js";
import { coloursOf, prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { copyFrom } from "../../util/copy.js";
import { byId, make } from "../../util/dom.js";
import { nameOf } from "../account/self.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Visitor } from "../../model/messages.js" */
/** @import { Landing, Owner } from "../../model/table/company.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const SHOWN_MS = 250; // between two renewals while balls rain
const TOLD_MS = 2100; // between two changes of name: the server takes no more for long

/** Of one table at a time. */
export class CompanyPanel {
  #tellTimer = 0;
  #toldMs = Number.NEGATIVE_INFINITY;

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.theme = theme;
    const { self } = game;
    game.onCalm("company", SHOWN_MS, () => this.#show());
    this.name = byId("self-name", HTMLInputElement);
    this.colours = byId("self-colours");
    this.#offerColours();
    this.name.value = self.appearance.name ?? "";
    this.name.addEventListener("change", () => this.#change());
    this.colours.addEventListener("change", () => this.#change());
    byId("self-form", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    byId("invite").addEventListener("click", () => this.#invite());
    theme.onChange(() => this.#show());
  }

  #show() {
    const { company } = this.game.room;
    const others = company.visitors.filter(({ visitor }) => visitor !== company.you);
    byId("company-here").textContent = company.here > 1
      ? t("company.others", { n: company.here - 1 })
      : t("company.alone");
    byId("people").replaceChildren(...others.map((visitor) => this.#person(visitor)));
    const { landings } = company;
    byId("landings").hidden = landings.every(({ mine }) => mine);
    byId("landings").replaceChildren(...landings.map((landing) => this.#landing(landing)));
  }

  /** @param {Visitor} visitor */
  #person(visitor) {
    return make("li", {}, swatch(swatchOf(visitor)), make("bdi", {}, called(visitor)));
  }

  /** @param {Landing} landing */
  #landing({ mine, owner, ball, score, bin }) {
    const own = owner?.colour ?? this.theme.palette.ball;
    const other = owner ? swatchOf(owner) : this.theme.palette.other;
    const who = make("bdi", {}, mine ? t("company.you") : called(owner));
    const row = make("li", {}, swatch(mine ? own : other), who, paidMark(this.theme, this.#board, bin, score));
    const { hello, own: drops } = this.game.room;
    // What others did to a ball is in no seed: there is nothing to replay alone.
    if (hello?.mode === "interacting") return row;
    const { seed, x, explicit, aim } = ball;
    const href = replayLink({ board: drops.address, seed, x: explicit ? x : null, aim });
    const link = make("a", { class: "again", href }, t("play.replay"));
    link.setAttribute("aria-label", t("company.replay", { who: who.textContent ?? "", pays: prizeOf(this.#board, bin, score) }));
    row.append(link);
    return row;
  }

  get #board() {
    return this.game.room.hello?.board ?? null;
  }

  #offerColours() {
    const { colour = "" } = this.game.self.appearance;
    const shown = ["", ...COLOURS, ...(colour && !COLOURS.includes(colour) ? [colour] : [])];
    this.colours.append(...shown.map((value, i) => {
      const radio = make("input", { type: "radio", name: "self-colour", value });
      radio.checked = value === colour;
      radio.setAttribute("aria-label", value ? t("company.colour", { n: i }) : t("company.no-colour"));
      const dot = value ? swatch(value) : make("i", { class: "swatch swatch-none" });
      return make("label", { class: "swatch-choice" }, radio, dot);
    }));
  }

  #change() {
    const name = nameOf(this.name.value);
    this.name.setAttribute("aria-invalid", String(name === null));
    byId("self-note").textContent = t(name === null ? "company.bad-name" : "company.note");
    if (name === null) return;
    const checked = this.colours.querySelector("input:checked");
    this.game.self.change({ name, colour: checked instanceof HTMLInputElement ? checked.value : "" });
    this.name.value = name;
    const wait = Math.max(0, this.#toldMs + TOLD_MS - performance.now());
    window.clearTimeout(this.#tellTimer);
    this.#tellTimer = window.setTimeout(() => {
      this.#toldMs = performance.now();
      this.game.room.appear();
    }, wait);
  }

  async #invite() {
    const link = new URL(`./?room=${encodeURIComponent(this.game.room.id)}`, document.baseURI).href;
    const copied = await copyFrom(byId("invite-link", HTMLInputElement), link);
    byId("invite-note").textContent = t(copied ? "company.copied" : "company.marked");
  }
}

/** @param {string} colour #rrggbb */
export function swatch(colour) {
  const dot = make("i", { class: "swatch" });
  dot.style.background = colour;
  return dot;
}

/** @param {Owner | null} owner @returns {string} */
export function called(owner) {
  if (owner?.name) return owner.name;
  return owner?.visitor === undefined ? t("company.someone") : t("company.guest", { n: owner.visitor });
}

/**
 * @param {Theme} theme @param {Board | null} board @param {number | null} bin @param {number} score
 * @returns {HTMLElement} the prize or the multiplier, in its bin's colour
 */
export function paidMark(theme, board, bin, score) {
  if (bin === null) return make("span", { class: "paid" }, t("play.void"));
  const paid = make("span", { class: "paid" }, make("bdi", {}, prizeOf(board, bin, score)));
  const { fill, ink } = coloursOf(board && labelOf(board, bin), theme.payout(score));
  Object.assign(paid.style, { background: fill, color: ink });
  return paid;
}
