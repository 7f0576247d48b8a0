// The drawer "Settings": language, colours, ghost trails, the anonymous ID.

import { language } from "../../texts/text.js";
import { byId, check, onChoice, onClick, radioValue } from "../../util/dom.js";

/** @import { Scheme, Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */
/** @import { Show } from "../show/show.js" */

const LANGUAGE_S = 365 * 24 * 3600;
const PAGES = new URL("../../../../", import.meta.url); // the folder next to the release

/** @param {Game} game @param {Theme} theme @param {Show} show */
export function offerSettings(game, theme, show) {
  // The server fills the pages' texts in, so the language is stored in a cookie, and the page is reloaded. Where the
  // browser blocks cookies, the page's address has the language.
  const choice = byId("language", HTMLSelectElement);
  choice.value = language;
  choice.addEventListener("change", () => {
    document.cookie = `language=${choice.value}; max-age=${LANGUAGE_S}; samesite=lax; path=${PAGES.pathname}`;
    const address = new URL(window.location.href);
    address.searchParams.delete("language");
    const stored = document.cookie.split("; ").includes(`language=${choice.value}`);
    if (!stored) address.searchParams.set("language", choice.value);
    if (address.href === window.location.href) window.location.reload();
    else window.location.replace(address);
  });

  const showScheme = () => check("scheme", theme.scheme);
  onChoice("scheme", () => theme.choose(/** @type {Scheme} */ (radioValue("scheme"))));
  theme.onChange(showScheme);
  showScheme();

  const showGhost = () => byId("ghost").setAttribute("aria-pressed", String(show.ghost.on));
  onClick("ghost", () => {
    show.setGhost(!show.ghost.on);
    showGhost();
  });
  showGhost();

  /** Links the drops that the server has under this player's ID. */
  const showMark = () => {
    const plays = `api/v1/players/${game.wallet.mark}/plays`;
    byId("plays-json", HTMLAnchorElement).href = plays;
    byId("plays-csv", HTMLAnchorElement).href = `${plays}?format=csv`;
  };
  onClick("mark-renew", () => {
    game.wallet.renewMark();
    showMark();
  });
  showMark();
}
