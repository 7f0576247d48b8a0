// The other players at the table, what they have won, the player's own name and colour, and an invitation link.

import { labelOf } from "../../model/board.js";
import { swatchOf } from "../../model/table/company.js";
import { COLOURS } from "../../model/player/colour.js";
import { replayLink } from "../../net/drop-address.js";
import { coloursOf, prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { copyFrom } from "../../util/copy.js";
import { byId, check, make, onClick, onSubmit, radioValue } from "../../util/dom.js";
import { nameOf } from "../account/self.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Landing, Owner } from "../../model/table/company.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const SHOWN_MS = 250; // between two updates while many balls land
const TOLD_MS = 2100; // between two changes of the name: the server refuses faster ones

/** @param {Game} game @param {Theme} theme */
export function showCompany(game, theme) {
  const show = () => {
    const { company } = game.room;
    const others = company.visitors.filter(({ visitor }) => visitor !== company.you);
    byId("company-here").textContent = company.here > 1
      ? t("company.others", { n: company.here - 1 })
      : t("company.alone");
    byId("people").replaceChildren(...others.map((visitor) =>
      make("li", {}, swatch(swatchOf(visitor)), make("bdi", {}, called(visitor)))));
    const { landings } = company;
    byId("landings").hidden = landings.every(({ mine }) => mine);
    byId("landings").replaceChildren(...landings.map((landing) => rowOf(landing, game, theme)));
  };
  game.onCalm("company", SHOWN_MS, show);
  theme.onChange(show);
  offerAppearance(game);
  onClick("invite", async () => {
    const link = new URL(`./?room=${encodeURIComponent(game.room.id)}`, document.baseURI).href;
    const copied = await copyFrom(byId("invite-link", HTMLInputElement), link);
    byId("invite-note").textContent = t(copied ? "company.copied" : "company.marked");
  });
}

/** @param {Landing} landing @param {Game} game @param {Theme} theme */
function rowOf({ mine, owner, ball, score, bin }, { room: { hello, own } }, theme) {
  const board = hello?.board ?? null;
  const colour = mine ? (owner?.colour ?? theme.palette.ball) : (owner ? swatchOf(owner) : theme.palette.other);
  const who = mine ? t("company.you") : called(owner);
  const row = make("li", {}, swatch(colour), make("bdi", {}, who), paidMark(theme, board, bin, score));
  // A ball that others knocked cannot be replayed from its seed.
  if (hello?.mode === "interacting") return row;
  const { seed, x, explicit, aim } = ball;
  const href = replayLink({ board: own.address, seed, x: explicit ? x : null, aim });
  const name = t("company.replay", { who, pays: prizeOf(board, bin, score) });
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
