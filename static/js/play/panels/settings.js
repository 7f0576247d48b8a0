// The drawer of what a player sets once: language, colours, ghost trails, the anonymous ID.

import { SCHEMES } from "../../paint/theme.js";
import { language } from "../../texts/text.js";
import { byId, radiosOf } from "../../util/dom.js";

/** @import { Theme } from "../../paint/theme.js" */
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
  const radios = radiosOf("scheme");
  const show = () => {
    for (const radio of radios) radio.checked = radio.value === theme.scheme;
  };
  for (const radio of radios) {
    radio.addEventListener("change", () => {
      const scheme = SCHEMES.find((one) => one === radio.value);
      if (scheme) theme.choose(scheme);
    });
  }
  theme.onChange(show);
  show();
}

/** @param {Game} game @param {Ghost} ghost */
function switchGhost(game, ghost) {
  const button = byId("ghost");
  /** @param {boolean} on */
  const set = (on) => {
    ghost.on = on;
    button.setAttribute("aria-pressed", String(on));
    game.tell("picture", null);
  };
  set(game.storage.getItem(GHOST_KEY) !== "off");
  button.addEventListener("click", () => {
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
  byId("mark-renew").addEventListener("click", () => {
    wallet.renewMark();
    show();
  });
  show();
}
