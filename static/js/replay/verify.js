// Recomputes and compares: the shown drop, in this page and by the server; and files with records or rooms' logs. Loaded
// when it is needed.

import { ApiError, getJson, messageOf, postJson } from "../net/api.js";
import { hasServer } from "../net/ask.js";
import { RecordError } from "../solver/errors.js";
import { readJson, textOfFile } from "../solver/input/json-text.js";
import { compareRecords } from "../solver/log/difference.js";
import { compareLog, isLog } from "../solver/log/log.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId, say } from "../util/dom.js";

/** @import { BoardReply, Verification } from "../net/replies.js" */
/** @import { Difference } from "../solver/log/difference.js" */
/** @import { Log } from "../solver/log/log.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { ImpactList } from "./impact-list.js" */
/** @import { Replay } from "./replay.js" */

const KNOWN = ["board", "board_digest", "seed", "x", "aim", "solver", "physics_version", "bin", "score", "label",
  "duration", "x_end", "impacts", "digest"];
const HOW_SURE = ["amplification", "x_error", "certain"]; // the server's to compute

const solving = openSolver();
solving.catch(() => {}); // a failure is shown when the solver is needed

/** @param {Replay} replay @param {ImpactList} list marks its impacts as verified */
export async function verify(replay, list) {
  const note = byId("verdict");
  say(note, "", t("page.computing"));
  const here = await inPage(replay, list);
  say(note, here.tone, here.text);
  if (here.tone === "bad" || !hasServer) return;
  const { tone, text } = await atServer(replay);
  say(note, tone === "" ? here.tone : tone, `${here.text} ${text}`);
}

/** @param {Replay} replay @param {ImpactList} list @returns {Promise<Said>} */
async function inPage({ board, record }, list) {
  if (record.solver !== "exact") return { tone: "", text: t("replay.exact-alone") };
  const solver = await solving.catch(messageOf);
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
    // The record is sent back as the same text, so that no number loses digits.
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

/** @param {File} file */
export async function checkFile(file) {
  const note = byId("check-note");
  say(note, "", t("replay.check-file", { file: file.name }));
  try {
    const value = readJson(await textOfFile(file));
    const { difference, words } = await (isLog(value) ? checkLog : checkRecord)(await solving, value, file.name);
    if (difference) say(note, "bad", t("replay.check-differs", { file: file.name, ...toldOf(difference) }));
    else say(note, "good", words);
  } catch (error) {
    say(note, "bad", t("replay.check-fails", { file: file.name, why: messageOf(error) }));
  }
}

/** @typedef {{difference: Difference | null, words: string}} Checked */

/** @param {Solver} solver @param {unknown} value @param {string} file its name @returns {Promise<Checked>} */
async function checkLog(solver, value, file) {
  const log = /** @type {Log} */ (value);
  const board = await boardOf(log.board);
  const difference = await compareLog(solver, log, board, async (done) => {
    say(byId("check-note"), "", t("replay.check-drops", { n: done }));
    await new Promise(requestAnimationFrame);
  });
  return { difference, words: t("replay.check-log", { file, n: log.drops.length, digest: String(log.digest) }) };
}

/** @param {Solver} solver @param {unknown} value @param {string} file its name @returns {Promise<Checked>} */
async function checkRecord(solver, value, file) {
  if (typeof value !== "object" || value === null || !("digest" in value) || !("board" in value)) {
    throw new RecordError(t("replay.no-record"), "");
  }
  const record = /** @type {Record<string, unknown>} */ (value);
  if (record.solver !== "exact") {
    throw new RecordError(t("replay.other-solver", { solver: String(record.solver) }), "solver");
  }
  const strange = Object.keys(record).find((name) => !KNOWN.includes(name) && !HOW_SURE.includes(name));
  if (strange) throw new RecordError(t("replay.strange-field", { field: strange }), strange);
  const start = /** @type {{seed: string | null, x?: number | null, aim?: number | null}} */ (record);
  const computed = solver.drop(await boardOf(record.board), start).record();
  const { same, difference } = compareRecords(record, computed);
  const words = [t("replay.check-record", { file, n: same, digest: computed.digest })];
  if (HOW_SURE.some((name) => name in record)) words.push(t("replay.check-unsure"));
  return { difference, words: words.join(" ") };
}

/** @param {unknown} board its JSON, or its name in REST @returns {Promise<unknown>} */
async function boardOf(board) {
  if (typeof board !== "string") return board;
  const reply = await getJson(`boards/${encodeURIComponent(board)}`);
  return /** @type {BoardReply} */ (reply).board;
}

/** @param {Difference} difference @returns {{field: string, expected: string, actual: string}} */
function toldOf({ field, expected, actual }) {
  return { field, expected: String(expected), actual: String(actual) };
}
