// The padlock: what was committed to before a drop, and after it the check of all of it.

import { readExport } from "../../fairness/export.js";
import { report, value } from "../../fairness/report.js";
import { openTools } from "../../fairness/tools.js";
import { messageOf, request } from "../../net/api.js";
import { showingToken } from "../../net/session-token.js";
import { t } from "../../texts/text.js";
import { byId, say } from "../../util/dom.js";
import { saveFile } from "../../util/file.js";

/** @import { Tools } from "../../fairness/check.js" */
/** @import { SessionEnded } from "../../model/messages.js" */
/** @import { Heard } from "../fairness/fair-play.js" */
/** @import { Game } from "../game.js" */

const SHORT = 8; // digits of a commitment in the padlock's tooltip, of a session in a file's name

/** Shows the session, and checks it once it is over. */
export class FairPanel {
  /** @type {Promise<Tools> | null} fetched by the first check */
  #tools = null;
  #saved = { name: "", text: "" };

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.padlock = byId("padlock");
    this.verdict = byId("fair-verdict");
    this.button = byId("fair-check", HTMLButtonElement);
    this.button.addEventListener("click", () => game.room.fair.end());
    for (const kind of /** @type {const} */ (["room", "account", "choice"])) game.on(kind, () => this.#show());
    game.on("ended", ({ ended, heard }) => this.#check(ended, heard));
    this.#show();
    byId("fair-save").addEventListener("click", () => {
      saveFile(this.#saved.name, this.#saved.text, "application/json");
    });
  }

  #show() {
    const { room, practice } = this.game;
    const { committed, open, state } = room.fair;
    this.padlock.hidden = practice !== null;
    this.padlock.dataset.open = String(open);
    const label = committed
      ? t("fair.committed", { lock: committed.slice(0, SHORT) })
      : t("fair.uncommitted");
    byId("padlock-text").textContent = committed ? t("play.sealed") : t("play.no-lock");
    this.padlock.setAttribute("aria-label", label);
    this.padlock.title = label;
    this.button.disabled = !state || state.drops === 0 || room.own.count > 0;
    if (!state) return;
    this.button.textContent = state.drops === 0
      ? t("fair.reveal")
      : t("fair.reveal-drops", { n: state.drops });
    byId("fair-values").replaceChildren(
      value(t("fair.server"), committed),
      value(t("fair.yours"), String(state.statement.client_commitment)),
      value(t("fair.session"), state.session),
      value(t("fair.key"), state.key),
    );
  }

  /** @param {SessionEnded} ended @param {Heard} heard what we were given meanwhile */
  async #check({ session }, heard) {
    this.verdict.hidden = false;
    say(this.verdict, "", t("page.computing"));
    try {
      const path = `sessions/${encodeURIComponent(session)}/export`;
      const reply = await request(path, showingToken(window.localStorage, session));
      const text = JSON.stringify({ ...(await reply.json()), ...heard });
      this.#saved = { name: `plinko-session-${session.slice(0, SHORT)}.json`, text };
      this.#tools ??= openTools();
      const places = { verdict: this.verdict, list: byId("fair-steps") };
      await report(readExport(text), await this.#tools, places);
    } catch (error) {
      say(this.verdict, "bad", t("fair.failed", { why: messageOf(error) }));
    }
    byId("fair-links").hidden = false;
    byId("fair-verify", HTMLAnchorElement).href = `verify.html?session=${encodeURIComponent(session)}`;
  }
}
