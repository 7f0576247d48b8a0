// The padlock: whether the next drops are sealed. It opens the drawer "Fairness".

import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Game } from "../game.js" */

/** @param {Game} game */
export function showPadlock(game) {
  const padlock = byId("padlock");
  const show = () => {
    const { committed, open } = game.room.fair;
    padlock.hidden = game.practice !== null;
    padlock.dataset.open = String(open);
    padlock.title = t(committed ? "fair.committed" : "fair.uncommitted");
    padlock.setAttribute("aria-label", padlock.title);
    byId("padlock-text").textContent = committed ? t("play.sealed") : t("play.no-lock");
  };
  for (const kind of /** @type {const} */ (["room", "account", "choice"])) game.on(kind, show);
  show();
}
