// The other players at the table, what they have won, and an invitation link. More of the panel is in visitors-parts.js.

import { swatchOf } from "../../model/table/visitors.js";
import { MINOR_UNITS } from "../../model/player/account.js";
import { replayLink } from "../../net/drop-address.js";
import { prizeOf } from "../../paint/prizes.js";
import { t } from "../../texts/text.js";
import { copyFrom } from "../../util/copy.js";
import { byId, make, onClick } from "../../util/dom.js";
import { amount } from "../../util/format.js";
import { called, paidMark, swatch } from "./list-marks.js";

/** @import { Landing } from "../../model/table/visitors.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const FED = 5; // landings of others next to the board
const SHOWN_MS = 250; // between two updates while many balls land

/** @param {Game} game @param {Theme} theme @param {boolean} touched whether there was a gesture before */
export function showVisitors(game, theme, touched) {
  const show = () => {
    const { visitors } = game.room;
    const present = visitors.present.filter(({ visitor }) => visitor !== visitors.you);
    byId("visitors-here").textContent = visitors.here > 1
      ? t("visitors.others", { n: visitors.here - 1 })
      : t("visitors.alone");
    byId("people").replaceChildren(...present.map((visitor) =>
      make("li", {}, swatch(swatchOf(visitor)), make("bdi", {}, called(visitor)))));
    const { landings } = visitors;
    byId("landings").hidden = landings.every(({ mine }) => mine);
    byId("landings").replaceChildren(...landings.map((landing) => rowOf(landing, game, theme)));
    const others = landings.filter(({ mine }) => !mine).slice(0, FED);
    byId("feed").replaceChildren(...others.map((landing) => make("li", {}, ...cellsOf(landing, game, theme))));
  };
  game.onCalm("visitors", SHOWN_MS, show);
  show();
  theme.onChange(show);
  /** @type {"" | "asked" | "failed"} */
  let more = "";
  const loadMore = async () => {
    if (more === "asked") return;
    more = "asked";
    const parts = await import("./visitors-parts.js").catch(() => null);
    if (!parts) {
      more = "failed"; // such as without a server: the next connection or touch tries again
      return;
    }
    parts.offerAppearance(game);
    parts.showBest(game, theme);
  };
  document.addEventListener("pointermove", loadMore, { once: true });
  for (const gesture of ["pointerdown", "keydown"]) document.addEventListener(gesture, loadMore);
  game.on("table", () => { if (more === "failed") void loadMore(); });
  if (touched) void loadMore();
  onClick("invite", async () => {
    const link = new URL(`./?room=${encodeURIComponent(game.room.id)}`, document.baseURI).href;
    const copied = await copyFrom(byId("invite-link", HTMLInputElement), link);
    byId("invite-note").textContent = t(copied ? "visitors.copied" : "visitors.marked");
  });
}

/** @param {Landing} landing @param {Game} game @param {Theme} theme @returns {HTMLElement[]} who won what */
function cellsOf({ mine, owner, score, bin, paid }, { room: { hello } }, theme) {
  const colour = mine ? (owner?.colour ?? theme.palette.ball) : (owner ? swatchOf(owner) : theme.palette.other);
  const who = mine ? t("visitors.you") : called(owner);
  const sum = make("span", { class: "sum" }, paid === null ? "" : amount(paid / MINOR_UNITS));
  return [swatch(colour), make("bdi", {}, who), paidMark(theme, hello?.board ?? null, bin, score), sum];
}

/** @param {Landing} landing @param {Game} game @param {Theme} theme */
function rowOf(landing, game, theme) {
  const { room: { hello, own } } = game;
  const { mine, owner, drop, score, bin } = landing;
  const row = make("li", {}, ...cellsOf(landing, game, theme));
  // A ball that others knocked cannot be replayed from its seed.
  if (hello?.mode === "interacting") return row;
  const href = replayLink({ board: own.address, ...drop });
  const who = mine ? t("visitors.you") : called(owner);
  const name = t("visitors.replay", { who, pays: prizeOf(hello?.board ?? null, bin, score) });
  row.append(make("a", { class: "again", href, "aria-label": name }, t("play.replay")));
  return row;
}
