// What a player reads when who runs the server halts the table, or lets it go on.

import { t } from "../texts/text.js";

/** @param {boolean} halted @returns {string} */
export function haltedWords(halted) {
  return halted ? t("play.halted") : t("play.resumed");
}
