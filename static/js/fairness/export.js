// The types of a fair session's export, and the check of its form.

import { JsonError, readJson, shownJson } from "../solver/input/json-text.js";

/**
 * @typedef {{statement: Record<string, unknown>, signature: string}} Signed
 *
 * @typedef {object} Receipt
 * @property {string} kind
 * @property {number} version
 * @property {string} session
 * @property {number} drop
 * @property {number} stake minor units
 * @property {number | null} aim m
 * @property {string} seed
 * @property {string} board_digest
 * @property {string} room
 * @property {number} ball
 * @property {number} time ms of Unix time
 *
 * @typedef {{receipt: Receipt, index: number, root: string, signature: string}} SignedReceipt
 *
 * @typedef {object} DropResult
 * @property {number | null} bin
 * @property {number} score
 * @property {number} t s
 * @property {number} x_end m
 * @property {string} digest
 * @property {string | null} unsettled
 * @property {number} payout minor units
 *
 * @typedef {SignedReceipt & {inclusion: string[], consistency: string[], result: DropResult | null}} ExportedDrop
 *
 * @typedef {object} SessionExport
 * @property {string} kind
 * @property {number} version
 * @property {string} key
 * @property {Signed} session
 * @property {Record<string, unknown>} board
 * @property {string | null} client_seed
 * @property {string | null} server_seed
 * @property {ExportedDrop[]} drops
 * @property {Signed} head
 * @property {Signed | null} end
 * @property {SignedReceipt[]} [heard] receipts that the player received during the session
 * @property {Signed | null} [heard_session] the statement received before the player revealed the client seed
 * @property {Draw} [draw] in a room that draws its bins with exact odds
 * @property {KeyChange[]} [keys] changes of the server's key since the session began, the latest first
 *
 * @typedef {Signed & {former_signature: string | null}} KeyChange former_signature: null if that key was lost
 *
 * @typedef {object} Draw
 * @property {string} kind
 * @property {number} version
 * @property {string} board_digest
 * @property {number[]} weights of the bins, left to right
 * @property {string[][]} seeds for each bin, seeds whose balls land there
 */

const KIND = "plinko-session";
const VERSION = 1;

const SIGNED = ["statement", "signature"];
const RECEIPT = ["receipt", "index", "root", "signature"];
const DROP = [...RECEIPT, "inclusion", "consistency", "result"];
const RESULT = ["bin", "score", "t", "x_end", "digest", "unsettled", "payout"];
const EARLIER = ["tick"]; // in exports of earlier versions; not checked, because nothing signed covers it
const EXPORT = ["kind", "version", "key", "session", "board", "client_seed", "server_seed", "drops",
  "head", "end"];
const HEARD = ["heard", "heard_session"]; // added by the player
const DRAWN = ["draw"]; // in a room that draws its bins
const CHANGED = ["keys"]; // if the server's key has changed
const DRAW = ["kind", "version", "board_digest", "weights", "seeds"];

/** The fields of each signed statement, in addition to `kind` and `version`. */
export const STATEMENTS = {
  "plinko session": ["session", "room", "board_digest", "payouts_digest", "physics_version",
    "kernel_digest", "server_commitment", "client_commitment", "time"],
  "plinko receipt": ["session", "drop", "stake", "aim", "seed", "board_digest", "room", "ball",
    "time"],
  "plinko tree head": ["size", "root", "time"],
  "plinko session end": ["session", "drops", "server_seed", "time"],
  "plinko key": ["key", "former", "time"],
};

/** Optional fields of statements. @type {Record<string, string[]>} */
const MORE = {
  "plinko session": ["draw_digest"], // in a room with a draw
  "plinko tree head": ["log"], // the id of a log that began with the restore of a backup
  "plinko session end": ["void"], // the restore of a backup ended the session
};

/** A text is not a valid export; the message says why. */
export class ExportError extends Error {}

/**
 * @param {string} text JSON
 * @returns {SessionExport} throws an ExportError
 */
export function readExport(text) {
  try {
    return checkedExport(readJson(text));
  } catch (error) {
    if (error instanceof JsonError) throw new ExportError(error.message);
    throw error;
  }
}

/** @param {unknown} value parsed JSON @returns {SessionExport} throws an ExportError */
export function checkedExport(value) {
  const found = /** @type {SessionExport} */ (object(value, "the export"));
  if (found.kind !== KIND) throw new ExportError(`kind is ${shownJson(found.kind)}: this is not the export of a fair session`);
  if (found.version !== VERSION) throw new ExportError(`version ${found.version} is not ${VERSION}`);
  fields(found, "the export", EXPORT, [...HEARD, ...DRAWN, ...CHANGED]);
  statement(found.session, "session", "plinko session");
  statement(found.head, "head", "plinko tree head");
  if (found.end !== null) statement(found.end, "end", "plinko session end");
  if (found.heard_session) statement(found.heard_session, "heard_session", "plinko session");
  if (found.keys !== undefined) list(found.keys, "keys").forEach((change, i) => checkChange(change, `keys[${i}]`));
  object(found.board, "board");
  if (found.draw !== undefined) checkDraw(found.draw);
  list(found.drops, "drops").forEach((drop, i) => checkDrop(drop, `drops[${i}]`));
  list(found.heard ?? [], "heard").forEach((heard, i) => checkReceipt(heard, `heard[${i}]`, RECEIPT));
  return found;
}

/** @param {unknown} value @param {string} where */
function checkChange(value, where) {
  const change = object(value, where);
  fields(change, where, [...SIGNED, "former_signature"]);
  stated(object(change.statement, where), where, "plinko key");
}

/** Checks only the form; check.js compares the digest with the signed one. @param {unknown} value */
function checkDraw(value) {
  const draw = object(value, "draw");
  fields(draw, "draw", DRAW);
  if (draw.kind !== "plinko draw" || draw.version !== VERSION) {
    throw new ExportError(`draw is not a plinko draw, version ${VERSION}`);
  }
  const weights = list(draw.weights, "draw.weights");
  weights.forEach((weight, bin) => whole(weight, `draw.weights[${bin}]`));
  const seeds = list(draw.seeds, "draw.seeds");
  const fits = seeds.length === weights.length && weights.some(Boolean)
    && seeds.every((some, bin) => Boolean(weights[bin]) === list(some, `draw.seeds[${bin}]`).length > 0);
  if (!fits) throw new ExportError("draw.seeds must have seeds for exactly the bins whose weight is above 0");
  const wrong = seeds.flatMap((some) => list(some, "draw.seeds")).find((seed) => !isSeed(seed));
  if (wrong !== undefined) throw new ExportError(`draw.seeds contains ${shownJson(wrong)}, which is not a seed`);
}

/** @param {unknown} value @returns {boolean} whether it is a decimal number below 2^64 without leading zeros */
function isSeed(value) {
  return typeof value === "string" && /^(0|[1-9][0-9]{0,19})$/.test(value) && BigInt(value) < 2n ** 64n;
}

/** @param {unknown} drop @param {string} where */
function checkDrop(drop, where) {
  const { inclusion, consistency, result } = checkReceipt(drop, where, DROP);
  list(inclusion, `${where}.inclusion`);
  list(consistency, `${where}.consistency`);
  if (result === null) return;
  const ended = object(result, `${where}.result`);
  fields(ended, `${where}.result`, RESULT, EARLIER);
  whole(ended.payout, `${where}.result.payout`);
}

/** @param {unknown} value @param {string} where @param {string[]} names */
function checkReceipt(value, where, names) {
  const found = object(value, where);
  fields(found, where, names);
  const receipt = object(found.receipt, `${where}.receipt`);
  stated(receipt, `${where}.receipt`, "plinko receipt");
  for (const name of ["drop", "stake", "ball", "time"]) whole(receipt[name], `${where}.${name}`);
  whole(found.index, `${where}.index`);
  return found;
}

/** @param {unknown} value @param {string} where @param {keyof typeof STATEMENTS} kind */
function statement(value, where, kind) {
  const signed = object(value, where);
  fields(signed, where, SIGNED);
  stated(object(signed.statement, where), where, kind);
}

/** @param {Record<string, unknown>} value @param {string} where @param {keyof typeof STATEMENTS} kind */
function stated(value, where, kind) {
  fields(value, where, ["kind", "version", ...STATEMENTS[kind]], MORE[kind]);
  if (value.kind !== kind || value.version !== VERSION) {
    throw new ExportError(`${where} is not a ${kind}, version ${VERSION}`);
  }
}

/** @param {unknown} value @param {string} where @returns {Record<string, unknown>} */
function object(value, where) {
  if (typeof value === "object" && value !== null && !Array.isArray(value)) {
    return /** @type {Record<string, unknown>} */ (value);
  }
  throw new ExportError(`${where} is not an object`);
}

/** @param {unknown} value @param {string} where @returns {unknown[]} */
function list(value, where) {
  if (Array.isArray(value)) return value;
  throw new ExportError(`${where} is not a list`);
}

/** @param {unknown} value @param {string} where */
function whole(value, where) {
  if (!Number.isSafeInteger(value) || Number(value) < 0) {
    throw new ExportError(`${where} is ${shownJson(value)}, which is not a whole number from 0 to ${Number.MAX_SAFE_INTEGER}`);
  }
}

/** @param {object} value @param {string} where @param {string[]} names @param {string[]} [more] */
function fields(value, where, names, more = []) {
  const lacking = names.find((name) => !(name in value));
  if (lacking) throw new ExportError(`${where} lacks ${lacking}`);
  const unknown = Object.keys(value).find((name) => !names.includes(name) && !more.includes(name));
  if (unknown) throw new ExportError(`${where} has an unknown field ${unknown}`);
}
