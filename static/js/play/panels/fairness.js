// The drawer "Fairness": the commitments before a drop, and the check of the session after its end.

import { value } from "../../fairness/value.js";
import { getText, messageOf } from "../../net/api.js";
import { showingToken } from "../../net/session-token.js";
import { canonical } from "../../solver/log/canonical.js";
import { t } from "../../texts/text.js";
import { byId, onClick, say } from "../../util/dom.js";
import { saveFile } from "../../util/file.js";

/** @import { Tools } from "../../fairness/check.js" */
/** @import { SessionEnded } from "../../model/messages.js" */
/** @import { Heard } from "../fairness/fair-play.js" */
/** @import { Game } from "../game.js" */

const SHORT = 8; // digits of a session in the file's name

/** Shows the session, and checks it when it has ended. @param {Game} game */
export function showFairness(game) {
  const verdict = byId("fair-verdict");
  /** @type {Promise<Tools> | null} fetched by the first check */
  let tools = null;
  let saved = { name: "", text: "" };
  let wanted = false; // whether the player has asked for the check: a full session ends by itself

  const show = () => {
    const { room } = game;
    const { committed, state } = room.fair;
    const button = byId("fair-check", HTMLButtonElement);
    button.disabled = !state || state.drops === 0 || room.own.count > 0;
    if (!state) return;
    button.textContent = state.drops === 0 ? t("fair.reveal") : t("fair.reveal-drops", { n: state.drops });
    byId("fair-values").replaceChildren(
      value(t("fair.server"), committed),
      value(t("fair.yours"), String(state.statement.client_commitment)),
      value(t("fair.session"), state.session),
      value(t("fair.key"), state.key),
    );
  };

  /** @param {SessionEnded} ended @param {Heard} heard what this page received during the session */
  const check = async ({ session }, heard) => {
    byId("fair-verify", HTMLAnchorElement).href = `verify.html?session=${encodeURIComponent(session)}`;
    byId("fair-links").hidden = false;
    byId("fair-save").hidden = !wanted;
    verdict.hidden = !wanted;
    byId("fair-steps").replaceChildren();
    if (!wanted) return;
    wanted = false;
    say(verdict, "", t("page.computing"));
    try {
      const { openTools, readExport, report } = await import("../../fairness/report.js");
      const path = `sessions/${encodeURIComponent(session)}/export`;
      const exported = readExport(await getText(path, showingToken(game.storage, session)));
      const text = canonical({ ...exported, ...heard });
      saved = { name: `plinko-session-${session.slice(0, SHORT)}.json`, text };
      tools ??= openTools();
      await report(readExport(text), await tools, { verdict, list: byId("fair-steps") });
    } catch (error) {
      say(verdict, "bad", t("fair.failed", { why: messageOf(error) }));
    }
  };

  onClick("fair-check", () => {
    wanted = true;
    game.room.fair.end();
  });
  onClick("fair-save", () => saveFile(saved.name, saved.text, "application/json"));
  for (const kind of /** @type {const} */ (["room", "account"])) game.on(kind, show);
  game.on("ended", ({ ended, heard }) => check(ended, heard));
  show();
}
