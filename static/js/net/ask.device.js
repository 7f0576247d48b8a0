// Takes the place of ask.js where there is no server: answers requests about boards, from the site's files and from
// what this device has stored. A board is also the room in which it is played.

import { readBoardName } from "../model/presets.js";
import { boardDigest } from "../solver/digest.js";
import { BoardError } from "../solver/errors.js";
import { readBoard } from "../solver/input/values.js";
import { t } from "../texts/text.js";
import { local } from "../util/storage.js";
import { isRecord, readStored } from "../util/stored.js";

/** @import { BoardList } from "./replies.js" */

export const hasServer = false;

const BOARDS = new URL("../../api/v1/boards.json", import.meta.url);
const KEY = "plinko.boards.1";
const KEPT = 20; // boards that are not presets, the latest

/** @type {Promise<BoardList> | null} */
let presets = null;

/**
 * @param {string} path below /api/v1, with its query
 * @param {RequestInit} [options]
 * @returns {Promise<Response>} rejects, as `fetch` does, where only a server could answer
 */
export async function ask(path, { method = "GET", body } = {}) {
  const { pathname, searchParams: query } = new URL(path, "file:///");
  const [resource, name, part] = pathname.slice(1).split("/").map(decodeURIComponent);
  const given = body ? JSON.parse(String(body)) : {};
  switch (`${method} ${resource}`) {
    case "GET boards":
      if (!name) return Response.json({ boards: await listed(query.get("digest")) });
      return readBoardName(name) ? file(part ? `boards/${name}/${part}` : `boards/${name}`) : own(name);
    case "POST boards":
      return read(given, name !== "check");
    case "GET rooms":
      if (query.has("id")) return Response.json({ rooms: known(query.get("id") ?? "") });
      break;
    case "POST rooms":
      if (typeof given.board === "string" && given.mode !== "interacting") return Response.json({ id: given.board });
      if (given.board && !given.mode) return read(given.board, true);
  }
  throw new TypeError(`${path} needs a server`);
}

/** @param {string} path of a reply that the site has as a file @returns {Promise<Response>} */
const file = (path) => fetch(new URL(`${path}.json`, BOARDS));

/** @param {string | null} digest of the only board wanted @returns {Promise<Partial<BoardList["boards"][0]>[]>} */
async function listed(digest) {
  const stored = Object.entries(kept()).map(([key, { name }]) => ({ name: String(name), digest: key, preset: false }));
  if (digest !== null && digest in kept()) return stored.filter((board) => board.digest === digest);
  presets ??= file("boards").then((reply) => reply.json());
  const { boards } = await presets;
  return [...boards, ...stored].filter((board) => digest === null || board.digest === digest);
}

/** @param {string} digest */
function own(digest) {
  const board = kept()[digest];
  return board ? Response.json({ board, digest }) : refusal(404, { detail: t("page.other-device") });
}

/** @param {string} id @returns {{id: string}[]} the room, if this device has its board */
function known(id) {
  return readBoardName(id) || id in kept() ? [{ id }] : [];
}

/** @param {unknown} form @param {boolean} keep whether to store it @returns {Response} */
function read(form, keep) {
  try {
    const board = readBoard(form);
    const digest = boardDigest(board);
    if (keep) {
      const others = Object.entries(kept()).filter(([other]) => other !== digest);
      const latest = [...others, [digest, board]].slice(-KEPT);
      local.setItem(KEY, JSON.stringify(Object.fromEntries(latest)));
    }
    return Response.json({ id: digest, board, digest });
  } catch (error) {
    if (!(error instanceof BoardError)) throw error;
    return refusal(422, { detail: error.message, field: error.field });
  }
}

/** @param {number} status @param {object} problem */
function refusal(status, problem) {
  return Response.json(problem, { status, headers: { "content-type": "application/problem+json" } });
}

/** @returns {Record<string, Record<string, unknown>>} boards by digest */
function kept() {
  return readStored(local, KEY, isBoards) ?? {};
}

/** @param {unknown} value @returns {value is Record<string, Record<string, unknown>>} */
const isBoards = (value) => isRecord(value) && Object.values(value).every(isRecord);
