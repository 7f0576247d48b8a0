// The key beside what is said of a ball that has landed: it hands the ball's link on.

import { replayLink } from "../../net/drop-address.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Game } from "../game.js" */

/** A link to the replay page; a click gives its address away at once. @param {Game} game */
export function offerLink(game) {
  const key = byId("hand-on", HTMLAnchorElement);
  const hide = () => { key.hidden = byId("near").hidden = true; };
  game.on("seen", (played) => {
    if (game.room.own.unseen > 0) return;
    key.href = replayLink(played);
    key.hidden = Boolean(played.knocked); // what others knocked has no replay of its own
  });
  game.on("run", () => { if (game.falling > 0) hide(); });
  game.on("table", hide);
  key.addEventListener("click", async (event) => {
    if (!navigator.share && !navigator.clipboard) return; // a page by plain HTTP has neither
    event.preventDefault();
    const url = `${key.href}&guess`; // who opens it guesses first
    try {
      // By the system's own sheet where there is one, else into the clipboard.
      if (navigator.share) await navigator.share({ title: document.title, url });
      else await navigator.clipboard.writeText(url);
      if (!navigator.share) game.say(t("play.link-copied"));
    } catch (error) {
      // Put away again, it is not asked for; whoever may not use either has the replay page.
      if (!(error instanceof DOMException && error.name === "AbortError")) window.location.assign(key.href);
    }
  });
}
