// What the panel of the table's visitors has after the first touch or key: the form for the player's own name and colour,
// and the best drop of the last 24 hours, which is the ledger's or one that was seen since.

import { MINOR_UNITS } from "../../model/player/account.js";
import { COLOURS } from "../../model/player/colour.js";
import { swatchOf } from "../../model/table/visitors.js";
import { ApiError, getJson } from "../../net/api.js";
import { replayLink } from "../../net/drop-address.js";
import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { byId, check, make, onSubmit, radioValue } from "../../util/dom.js";
import { amount } from "../../util/format.js";
import { nameOf } from "../account/self.js";
import { called, paidMark, swatch } from "./list-marks.js";

/** @import { Owner } from "../../model/table/visitors.js" */
/** @import { Plays } from "../../net/replies.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const TOLD_MS = 2100; // between two changes of the name: the server refuses faster ones
const GREAT = 10; // the least multiplier, as in the ledger

/** @typedef {{owner: Owner | null, bin: number | null, score: number, paid: number, href: string}} Best paid: minor units */

/** @param {Game} game @param {Theme} theme */
export function showBest(game, theme) {
  /** @type {Best | null} */
  let best = null;

  const show = () => {
    byId("best-today").hidden = byId("best-key").hidden = best === null;
    const { hello } = game.room;
    if (!best || !hello) return;
    const { owner, bin, score, paid, href } = best;
    const pays = prizeOf(hello.board, bin, score);
    const [who, sum] = [called(owner), amount(paid / MINOR_UNITS)];
    const replay = make("a", { class: "again", href, "aria-label": t("visitors.replay", { who, pays }) }, t("play.replay"));
    const colour = owner ? swatchOf(owner) : theme.palette.other;
    byId("best-row").replaceChildren(swatch(colour), make("bdi", {}, who), paidMark(theme, hello.board, bin, score),
      make("span", { class: "sum" }, sum), replay);
    const key = byId("best-key", HTMLAnchorElement);
    key.href = href;
    key.textContent = t("visitors.best-key", { pays, sum });
  };
  /** @param {Best} found */
  const take = (found) => {
    if (found.score < GREAT || found.paid <= (best?.paid ?? 0)) return;
    best = found;
    show();
  };
  const read = async () => {
    const { id } = game.room;
    best = null;
    show();
    try {
      const { plays } = /** @type {Plays} */ (await getJson(`rooms/${encodeURIComponent(id)}/best`));
      if (id !== game.room.id) return;
      for (const { name, colour, bin, score, payout, board_digest: board, seed, x, aim } of plays) {
        const owner = name || colour ? { name: name ?? undefined, colour: colour ?? undefined } : null;
        take({ owner, bin, score, paid: payout, href: replayLink({ board, seed, x, aim }) });
      }
    } catch (error) {
      if (!(error instanceof ApiError)) throw error; // without a server there is no best drop
    }
  };
  game.on("table", read);
  game.on("landed", ({ owner, bin, score, paid, drop }) => {
    take({ owner, bin, score, paid: paid ?? 0, href: replayLink({ board: game.room.own.address, ...drop }) });
  });
  theme.onChange(show);
}

/** The form for the player's own name and colour. @param {Game} game */
export function offerAppearance(game) {
  const name = byId("self-name", HTMLInputElement);
  const { colour: chosen = "", name: kept = "" } = game.self.appearance;
  const shown = ["", ...COLOURS, ...(chosen && !COLOURS.includes(chosen) ? [chosen] : [])];
  byId("self-colours").append(...shown.map((value, i) => {
    const words = value ? t("visitors.colour", { n: i }) : t("visitors.no-colour");
    const radio = make("input", { type: "radio", name: "self-colour", value, "aria-label": words });
    const dot = value ? swatch(value) : make("i", { class: "swatch swatch-none" });
    return make("label", { class: "swatch-choice" }, radio, dot);
  }));
  check("self-colour", chosen);
  const typed = name.value !== ""; // before this was loaded
  if (!typed) name.value = kept;
  let timer = 0;
  let toldMs = Number.NEGATIVE_INFINITY;
  onSubmit("self-form");
  const change = () => {
    const text = nameOf(name.value);
    name.setAttribute("aria-invalid", String(text === null));
    byId("self-note").textContent = t(text === null ? "visitors.bad-name" : "visitors.note");
    if (text === null) return;
    game.self.change({ name: text, colour: radioValue("self-colour") });
    name.value = text;
    window.clearTimeout(timer);
    timer = window.setTimeout(() => {
      toldMs = performance.now();
      game.room.appear();
    }, Math.max(0, toldMs + TOLD_MS - performance.now()));
  };
  byId("self-form").addEventListener("change", change);
  if (typed && document.activeElement !== name) change(); // else it changes when the field is left
}
