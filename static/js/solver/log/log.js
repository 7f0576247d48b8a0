// Recomputes a room's log and compares every landing, the world at the end, and the log's digest.

import { exactPayout } from "../../model/payout.js";
import { Bytes } from "../encoding/bytes.js";
import { boardDigest, PHYSICS_VERSION } from "../digest.js";
import { RecordError } from "../errors.js";
import { sha256 } from "../encoding/sha256.js";
import { canonical } from "./canonical.js";
import { ENTRY, ENTRY_OPTIONAL, NEEDED, OPTIONAL, RESULT, UNCOVERED } from "./fields.js";
import { worldDigest } from "./world.js";

/** @import { Difference } from "./difference.js" */
/** @import { Drop } from "../drop.js" */
/** @import { Solver } from "../solver.js" */
/** @import { Flying } from "./world.js" */

/**
 * @typedef {Record<string, unknown>} Fields
 * @typedef {Fields & {ball: number, tick: number, seed: string, x?: number | null, aim?: number | null,
 *   result: Fields | null}} Entry
 * @typedef {Fields & {version: number, tick: number, tick_rate: number, world_digest: string,
 *   digest: string, drops: Entry[]}} Log
 */

const KIND = "plinko-room";
const VERSION = 2;
const AT_ONCE = 50; // drops between two pauses

/** @param {unknown} value @returns {boolean} whether it is a room's log, and not a drop's record */
export function isLog(value) {
  return isFields(value) && value.kind === KIND;
}

/**
 * @param {Solver} solver
 * @param {unknown} value the log, as `readJson` of input/json-text.js returns it; throws a RecordError that names an invalid field
 * @param {unknown} form its board's JSON, parsed
 * @param {(drops: number) => void | Promise<void>} [pause] called, and awaited, after every 50 drops, with
 *   the number of drops compared until then
 * @returns {Promise<Difference | null>} the first field that differs, or null if none does
 */
export async function compareLog(solver, value, form, pause = () => {}) {
  const log = logOf(value);
  const board = solver.read(form);
  const digest = boardDigest(board);
  const other = compareFields(log, {
    version: VERSION,
    board_digest: digest,
    solver: "exact",
    physics_version: PHYSICS_VERSION,
  });
  if (other) return other;
  const dt = 1 / log.tick_rate;
  /** @type {Flying[]} */
  const flying = [];
  for (const [number, entry] of log.drops.entries()) {
    checkEntry(entry, number, log);
    const drop = solver.drop(board, { seed: entry.seed, x: entry.x, aim: entry.aim });
    const ended = tickOf(drop.duration, dt) + entry.tick;
    const found = ended <= log.tick ? resultOf(drop, ended, entry.stake) : null;
    const different = compareResult(`drops[${number}].result`, entry, found);
    if (different) return different;
    const seed = String(BigInt(entry.seed));
    if (!found) flying.push({ id: number, seed, tick: entry.tick, drop });
    if ((number + 1) % AT_ONCE === 0) await pause(number + 1);
  }
  const world = { board: digest, dt, tick: log.tick, dropped: log.drops.length, flying };
  return compareFields(log, { world_digest: worldDigest(world), digest: logDigest(log) });
}

/** @param {unknown} value @returns {Log} */
function logOf(value) {
  if (!isFields(value)) throw new RecordError("a log is one JSON object", "");
  const log = /** @type {Log} */ (value);
  if ((log.mode ?? "independent") !== "independent") {
    throw new RecordError("mode is interacting: only logs of independent balls can be compared here. "
      + "Use plinko verify, which compares both", "mode");
  }
  checkNames(log, NEEDED, [...NEEDED, ...OPTIONAL], "the log");
  if (!Array.isArray(log.drops)) throw new RecordError("drops is not a list", "drops");
  checkWhole(log, "tick_rate", 1);
  checkWhole(log, "tick", 0);
  return log;
}

/** @param {Entry} entry @param {number} number @param {Log} log */
function checkEntry(entry, number, log) {
  const where = `drops[${number}]`;
  if (!isFields(entry)) throw new RecordError(`${where} is not an object`, where);
  checkNames(entry, ENTRY, [...ENTRY, ...ENTRY_OPTIONAL], where);
  if (entry.ball !== number) {
    throw new RecordError(`${where}.ball is ${String(entry.ball)}: balls are numbered from 0, `
      + "none left out", `${where}.ball`);
  }
  checkWhole(entry, "tick", log.drops[number - 1]?.tick ?? 0, `${where}.`);
  if (entry.tick > log.tick) {
    throw new RecordError(`${where}.tick ${entry.tick} is after the log's tick ${log.tick}`, "tick");
  }
  checkWhole({ stake: 0, ...entry }, "stake", 0, `${where}.`);
  if (entry.result === null) return;
  if (!isFields(entry.result)) throw new RecordError(`${where}.result is not an object`, where);
  checkNames(entry.result, RESULT, RESULT, `${where}.result`);
}

/** @param {Fields} fields @param {string[]} needed @param {string[]} known @param {string} where */
function checkNames(fields, needed, known, where) {
  const lacking = needed.find((name) => !(name in fields));
  if (lacking) throw new RecordError(`${where} lacks ${lacking}`, lacking);
  const unknown = Object.keys(fields).find((name) => !known.includes(name));
  if (unknown) throw new RecordError(`${where} has an unknown field ${unknown}`, unknown);
}

/** @param {Fields} fields @param {string} name @param {number} least @param {string} [where] */
function checkWhole(fields, name, least, where = "") {
  const value = fields[name];
  if (Number.isSafeInteger(value) && Number(value) >= least) return;
  const text = `${where}${name} ${String(value)} is not a whole number from ${least} on`;
  throw new RecordError(text, where + name);
}

/** @param {unknown} value @returns {value is Fields} */
const isFields = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** @param {number} time s @param {number} dt s @returns {number} the first tick at or after the time */
function tickOf(time, dt) {
  let tick = Math.max(1, Math.floor(time / dt) - 1);
  while (tick * dt < time) tick += 1;
  return tick;
}

/** @param {Drop} drop @param {number} tick of its landing @param {unknown} stake minor units */
function resultOf(drop, tick, stake) {
  const { bin, score, duration: t, xEnd, digest, unsettled } = drop;
  const payout = exactPayout(Number(stake ?? 0), score);
  return { tick, bin, score, t, x_end: xEnd, digest, unsettled, payout };
}

/** @param {string} where @param {Entry} entry @param {Fields | null} found @returns {Difference | null} */
function compareResult(where, { result: said, stake }, found) {
  // The stake of a drop whose room was closed while the ball was in flight has been returned.
  const ended = found ?? (said?.digest === "" ? { bin: null, score: 1, payout: stake ?? 0 } : null);
  if (said && ended) return compareFields(said, ended, `${where}.`);
  if (!said && !ended) return null;
  const words = (/** @type {Fields | null} */ result) => (result ? canonical(result) : "none yet");
  return { field: where, expected: words(said), actual: words(found) };
}

/** @param {Fields} said @param {Fields} found @param {string} [where] @returns {Difference | null} */
function compareFields(said, found, where = "") {
  const name = Object.keys(found).find((key) => canonical(said[key]) !== canonical(found[key]));
  return name === undefined
    ? null
    : { field: where + name, expected: said[name], actual: found[name] };
}

/** @param {Entry} entry @returns {Fields} the fields that the log's digest covers */
function covered(entry) {
  return Object.fromEntries(Object.entries(entry).filter(([name]) => !UNCOVERED.includes(name)));
}

/** @param {Log} log @returns {string} 64 hexadecimal digits */
function logDigest(log) {
  const { drops } = log;
  const head = Object.entries(log).filter(([name]) => name !== "drops" && name !== "digest");
  const out = new Bytes();
  for (const line of [Object.fromEntries(head), ...drops.map(covered)]) out.text(`${canonical(line)}\n`);
  return sha256(out.written);
}
