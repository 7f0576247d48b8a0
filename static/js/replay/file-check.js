// A record or a room's log that is dropped onto the page: computed anew here, and compared.

import { getJson, messageOf } from "../net/api.js";
import { compareRecords } from "../solver/log/difference.js";
import { RecordError } from "../solver/errors.js";
import { readJson } from "../solver/log/canonical.js";
import { compareLog, isLog } from "../solver/log/log.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId, onClick, say } from "../util/dom.js";
import { toldOf } from "./verify.js";

/** @import { BoardReply } from "../net/replies.js" */
/** @import { Difference } from "../solver/log/difference.js" */
/** @import { Log } from "../solver/log/log.js" */
/** @import { Solver } from "../solver/solver.js" */

/** @typedef {Record<string, unknown>} Fields */

const KNOWN = ["board", "board_digest", "seed", "x", "aim", "solver", "physics_version", "bin", "score", "label",
  "duration", "x_end", "impacts", "digest"];
const HOW_SURE = ["amplification", "x_error", "certain"]; // the server's to compute

/** The panel, and the whole page as a place to drop a file on. */
export function offerFileCheck() {
  const solving = openSolver();
  solving.catch(() => {}); // told when a file comes
  const field = byId("check-file", HTMLInputElement);
  onClick("check-open", () => field.click());
  field.addEventListener("change", () => {
    check(field.files?.[0], solving);
    field.value = ""; // the same file can be chosen again
  });
  document.addEventListener("dragover", (event) => {
    if (event.dataTransfer?.types.includes("Files")) event.preventDefault();
  });
  document.addEventListener("drop", (event) => {
    const dropped = event.dataTransfer?.files[0];
    if (!dropped) return;
    event.preventDefault();
    byId("check-panel").scrollIntoView({ block: "nearest" });
    check(dropped, solving);
  });
}

/** @param {File | undefined} file @param {Promise<Solver>} solving */
async function check(file, solving) {
  if (!file) return;
  const note = byId("check-note");
  say(note, "", t("replay.check-file", { file: file.name }));
  try {
    const value = readJson(await file.text());
    const { difference, words } = await (isLog(value) ? checkLog : checkRecord)(await solving, value, file.name);
    if (difference) say(note, "bad", t("replay.check-differs", { file: file.name, ...toldOf(difference) }));
    else say(note, "good", words);
  } catch (error) {
    const why = error instanceof SyntaxError ? t("replay.not-json", { why: error.message }) : messageOf(error);
    say(note, "bad", t("replay.check-fails", { file: file.name, why }));
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
  const record = /** @type {Fields} */ (value);
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

/** @param {unknown} board its JSON, or what REST calls it @returns {Promise<unknown>} */
async function boardOf(board) {
  if (typeof board !== "string") return board;
  const reply = await getJson(`boards/${encodeURIComponent(board)}`);
  return /** @type {BoardReply} */ (reply).board;
}
