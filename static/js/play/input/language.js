// The choice of the page's language: kept in a cookie, for the server fills the pages.

import { language } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

const KEPT_S = 365 * 24 * 3600;

/** Shows the language, and comes again in another that is chosen. */
export function chooseLanguage() {
  const choice = byId("language", HTMLSelectElement);
  choice.value = language;
  choice.addEventListener("change", () => {
    document.cookie = `language=${choice.value}; max-age=${KEPT_S}; samesite=lax`;
    window.location.reload();
  });
}
