// The other players at the table, what they have won, the player's own name and colour, and an invitation link.

import { labelOf } from "../../model/board.js";
import { swatchOf } from "../../model/table/company.js";
import { MINOR_UNITS } from "../../model/player/account.js";
import { COLOURS } from "../../model/player/colour.js";
import { replayLink } from "../../net/drop-address.js";
import { coloursOf, prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { copyFrom } from "../../util/copy.js";
import { byId, check, make, onClick, onSubmit, radioValue } from "../../util/dom.js";
import { amount } from "../../util/format.js";
import { nameOf } from "../account/self.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Landing, Owner } from "../../model/table/company.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */
/** @import { showBest } from "./best.js" */

const FED = 5; // landings of others next to the board
const SHOWN_MS = 250; // between two updates while many balls land
const TOLD_MS = 2100; // between two changes of the name: the server refuses faster ones

/** @param {Game} game @param {Theme} theme */
export function showCompany(game, theme) {
  const show = () => {
    const { company } = game.room;
    const visitors = company.visitors.filter(({ visitor }) => visitor !== company.you);
    byId("company-here").textContent = company.here > 1
      ? t("company.others", { n: company.here - 1 })
      : t("company.alone");
    byId("people").replaceChildren(...visitors.map((visitor) =>
      make("li", {}, swatch(swatchOf(visitor)), make("bdi", {}, called(visitor)))));
    const { landings } = company;
    byId("landings").hidden = landings.every(({ mine }) => mine);
    byId("landings").replaceChildren(...landings.map((landing) => rowOf(landing, game, theme)));
    const others = landings.filter(({ mine }) => !mine).slice(0, FED);
    byId("feed").replaceChildren(...others.map((landing) => make("li", {}, ...cellsOf(landing, game, theme))));
  };
  game.onCalm("company", SHOWN_MS, show);
  theme.onChange(show);
  let best = false;
  const first = async () => {
    if (best) return;
    best = true;
    /** @type {{showBest: typeof showBest}} */
    const panel = await import(new URL("best.js", import.meta.url).href);
    panel.showBest(game, theme);
  };
  for (const gesture of ["pointerover", "keydown"]) document.addEventListener(gesture, first, { once: true });
  offerAppearance(game);
  onClick("invite", async () => {
    const link = new URL(`./?room=${encodeURIComponent(game.room.id)}`, document.baseURI).href;
    const copied = await copyFrom(byId("invite-link", HTMLInputElement), link);
    byId("invite-note").textContent = t(copied ? "company.copied" : "company.marked");
  });
}

/** @param {Landing} landing @param {Game} game @param {Theme} theme @returns {HTMLElement[]} who won what */
function cellsOf({ mine, owner, score, bin, paid }, { room: { hello } }, theme) {
  const colour = mine ? (owner?.colour ?? theme.palette.ball) : (owner ? swatchOf(owner) : theme.palette.other);
  const who = mine ? t("company.you") : called(owner);
  const sum = make("span", { class: "sum" }, paid === null ? "" : amount(paid / MINOR_UNITS));
  return [swatch(colour), make("bdi", {}, who), paidMark(theme, hello?.board ?? null, bin, score), sum];
}

/** @param {Landing} landing @param {Game} game @param {Theme} theme */
function rowOf(landing, game, theme) {
  const { room: { hello, own } } = game;
  const { mine, owner, ball, score, bin } = landing;
  const row = make("li", {}, ...cellsOf(landing, game, theme));
  // A ball that others knocked cannot be replayed from its seed.
  if (hello?.mode === "interacting") return row;
  const { seed, x, explicit, aim } = ball;
  const href = replayLink({ board: own.address, seed, x: explicit ? x : null, aim });
  const who = mine ? t("company.you") : called(owner);
  const name = t("company.replay", { who, pays: prizeOf(hello?.board ?? null, bin, score) });
  row.append(make("a", { class: "again", href, "aria-label": name }, t("play.replay")));
  return row;
}

/** The form for the player's own name and colour. @param {Game} game */
function offerAppearance(game) {
  const name = byId("self-name", HTMLInputElement);
  const { colour: chosen = "", name: kept = "" } = game.self.appearance;
  const shown = ["", ...COLOURS, ...(chosen && !COLOURS.includes(chosen) ? [chosen] : [])];
  byId("self-colours").append(...shown.map((value, i) => {
    const words = value ? t("company.colour", { n: i }) : t("company.no-colour");
    const radio = make("input", { type: "radio", name: "self-colour", value, "aria-label": words });
    const dot = value ? swatch(value) : make("i", { class: "swatch swatch-none" });
    return make("label", { class: "swatch-choice" }, radio, dot);
  }));
  check("self-colour", chosen);
  name.value = kept;
  let timer = 0;
  let toldMs = Number.NEGATIVE_INFINITY;
  onSubmit("self-form");
  byId("self-form").addEventListener("change", () => {
    const text = nameOf(name.value);
    name.setAttribute("aria-invalid", String(text === null));
    byId("self-note").textContent = t(text === null ? "company.bad-name" : "company.note");
    if (text === null) return;
    game.self.change({ name: text, colour: radioValue("self-colour") });
    name.value = text;
    window.clearTimeout(timer);
    timer = window.setTimeout(() => {
      toldMs = performance.now();
      game.room.appear();
    }, Math.max(0, toldMs + TOLD_MS - performance.now()));
  });
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
