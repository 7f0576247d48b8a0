// The share button next to a result: it shares the link to the ball's replay.

import { replayLink } from "../../net/drop-address.js";
import { hasServer } from "../../net/ask.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Game } from "../game.js" */

/** A link to the replay page; a click shares or copies it. @param {Game} game */
export function offerLink(game) {
  const key = byId("hand-on", HTMLAnchorElement);
  const hide = () => { key.hidden = byId("near").hidden = true; };
  game.on("seen", (played) => {
    if (game.room.own.unseen > 0) return;
    key.href = replayLink(played);
    key.hidden = Boolean(played.knocked); // a ball that others knocked cannot be replayed alone
  });
  game.on("run", () => { if (game.falling > 0) hide(); });
  game.on("table", hide);
  key.addEventListener("click", async (event) => {
    if (!navigator.share && !navigator.clipboard) return; // plain HTTP has neither: the link is followed
    // The link to a board of this device is on the replay page.
    if (!hasServer && game.room.practice === "unsolved") return;
    event.preventDefault();
    const url = `${key.href}&guess`; // the recipient guesses the bin first
    try {
      // The system's share sheet if there is one, else the clipboard.
      if (navigator.share) await navigator.share({ title: document.title, url });
      else await navigator.clipboard.writeText(url);
      if (!navigator.share) game.say(t("play.link-copied"));
    } catch (error) {
      // AbortError: the player closed the sheet. If sharing is not permitted, the replay page opens.
      if (!(error instanceof DOMException && error.name === "AbortError")) window.location.assign(key.href);
    }
  });
}
