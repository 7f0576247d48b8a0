// The key beside what is said of a ball that has landed: it hands the ball's link on.

import { replayLink } from "../../net/drop-address.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Game } from "../game.js" */
/** @import { Played } from "../../model/player/account.js" */

/** A link to the replay page, which has all else to hand on; a click gives its address away at once. */
export class HandOn {
  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.key = byId("hand-on", HTMLAnchorElement);
    game.on("seen", (played) => { if (game.room.own.unseen === 0) this.#offer(played); });
    game.on("run", () => { if (game.falling > 0) this.key.hidden = byId("near").hidden = true; });
    game.on("table", () => { this.key.hidden = byId("near").hidden = true; });
    this.key.addEventListener("click", (event) => {
      if (!navigator.share && !navigator.clipboard) return; // a page by plain HTTP has neither
      event.preventDefault();
      // Who opens it guesses first.
      this.#give(`${this.key.href}&guess`);
    });
  }

  /** @param {Played} played it has landed; one that others knocked has no replay of its own */
  #offer(played) {
    this.key.href = replayLink(played);
    this.key.hidden = Boolean(played.knocked);
  }

  /** By the system's own sheet where there is one, else into the clipboard. @param {string} url */
  async #give(url) {
    try {
      if (navigator.share) await navigator.share({ title: document.title, url });
      else await navigator.clipboard.writeText(url);
      if (!navigator.share) this.game.say(t("play.link-copied"));
    } catch (error) {
      // Put away again, it is not asked for; whoever may not use either has the replay page.
      if (!(error instanceof DOMException && error.name === "AbortError")) window.location.assign(this.key.href);
    }
  }
}
