// Verify: the drop is computed anew in this page, and by the server if it answers, and compared.

import { ApiError, messageOf, postJson } from "../net/api.js";
import { compareRecords } from "../solver/log/difference.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId, say } from "../util/dom.js";

/** @import { Verification } from "../net/replies.js" */
/** @import { Difference } from "../solver/log/difference.js" */
/** @import { ImpactList } from "./impact-list.js" */
/** @import { Replay } from "./replay.js" */

/** Loaded with the page, so that no server is needed; or why it cannot be. */
const solving = openSolver().catch(messageOf);

/** @param {Replay} replay @param {ImpactList} list whose impacts turn green */
export async function verify(replay, list) {
  const note = byId("verdict");
  say(note, "", t("page.computing"));
  const here = await inPage(replay, list);
  say(note, here.tone, here.text);
  if (here.tone === "bad") return;
  const { tone, text } = await atServer(replay);
  say(note, tone === "" ? here.tone : tone, `${here.text} ${text}`);
}

/** @param {Replay} replay @param {ImpactList} list @returns {Promise<Said>} */
async function inPage({ board, record }, list) {
  if (record.solver !== "exact") return { tone: "", text: t("replay.exact-alone") };
  const solver = await solving;
  if (typeof solver === "string") return { tone: "", text: t("replay.not-here", { why: solver }) };
  const start = { seed: record.seed, x: record.x, aim: record.aim };
  const computed = solver.drop(board, start).record();
  const { same, difference } = compareRecords({ ...record }, computed);
  await list.turnGreen(same);
  if (difference) return { tone: "bad", text: t("replay.other-here", toldOf(difference)) };
  return { tone: "good", text: t("replay.same-here", { n: same, digest: computed.digest }) };
}

/** @typedef {{tone: "" | "good" | "bad", text: string}} Said */

/** @param {Replay} replay @returns {Promise<Said>} */
async function atServer({ text, record, board }) {
  try {
    // The record goes back as it came, to the last bit of its numbers.
    const asked = text ?? JSON.stringify({ ...record, board });
    const reply = /** @type {Verification} */ (await postJson("verify", asked));
    const { ok, field, expected, actual } = reply;
    if (!ok) return { tone: "bad", text: t("replay.other-there", toldOf({ field: field ?? "", expected, actual })) };
    return { tone: "good", text: t("replay.same-there", { n: record.impacts.length, digest: record.digest }) };
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    return { tone: error.status === 0 ? "" : "bad", text: error.message };
  }
}

/** @param {Difference} difference @returns {{field: string, expected: string, actual: string}} */
export function toldOf({ field, expected, actual }) {
  return { field, expected: String(expected), actual: String(actual) };
}
