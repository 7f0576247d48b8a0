// The drawer of what a player sets once: language, colours, ghost trails, the anonymous ID.

import { language } from "../../texts/text.js";
import { byId, check, onChoice, onClick, radioValue } from "../../util/dom.js";

/** @import { Scheme, Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */
/** @import { Ghost } from "../show/ghost.js" */

const LANGUAGE_S = 365 * 24 * 3600;
const GHOST_KEY = "plinko.ghost.1";

/** @param {Game} game @param {Theme} theme @param {Ghost} ghost */
export function offerSettings(game, theme, ghost) {
  chooseLanguage();
  chooseScheme(theme);
  switchGhost(game, ghost);
  showMark(game);
}

/** Kept in a cookie, for the server fills the pages; the page comes again in another language. */
function chooseLanguage() {
  const choice = byId("language", HTMLSelectElement);
  choice.value = language;
  choice.addEventListener("change", () => {
    document.cookie = `language=${choice.value}; max-age=${LANGUAGE_S}; samesite=lax`;
    window.location.reload();
  });
}

/** @param {Theme} theme */
function chooseScheme(theme) {
  const show = () => check("scheme", theme.scheme);
  onChoice("scheme", () => theme.choose(/** @type {Scheme} */ (radioValue("scheme"))));
  theme.onChange(show);
  show();
}

/** @param {Game} game @param {Ghost} ghost */
function switchGhost(game, ghost) {
  /** @param {boolean} on */
  const set = (on) => {
    ghost.on = on;
    byId("ghost").setAttribute("aria-pressed", String(on));
    game.tell("picture", null);
  };
  set(game.storage.getItem(GHOST_KEY) !== "off");
  onClick("ghost", () => {
    set(!ghost.on);
    game.storage.setItem(GHOST_KEY, ghost.on ? "on" : "off");
  });
}

/** The ID by which the server finds a player's drops again. @param {Game} game */
function showMark({ wallet }) {
  const show = () => {
    const plays = `api/v1/players/${wallet.mark}/plays`;
    byId("plays-json", HTMLAnchorElement).href = plays;
    byId("plays-csv", HTMLAnchorElement).href = `${plays}?format=csv`;
  };
  onClick("mark-renew", () => {
    wallet.renewMark();
    show();
  });
  show();
}
