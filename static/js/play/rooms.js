// Finds or opens the room for a chosen board, and keeps the page's address in step.

import { getJson, postJson } from "../net/api.js";
import { boardName, MAIN_ROOM, readBoardName, roomOf } from "../model/presets.js";
import { isOwn, readWorldName, transported } from "../model/worlds.js";

/** @import { Visited } from "../model/player/visited.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { Choice } from "../model/presets.js" */
/** @import { Custom } from "../model/worlds.js" */
/** @import { BoardReply, RoomList, RoomReply } from "../net/replies.js" */

/** @typedef {Choice & Custom & {knock: boolean}} TableChoice knock: whether balls knock each other */

/** @param {Hello} hello @returns {TableChoice | null} null for a board that the form does not offer */
export function choiceOf({ board_name: name, mode }) {
  const { preset, ...custom } = readWorldName(name);
  const choice = readBoardName(preset);
  return choice && { ...choice, ...custom, knock: mode === "interacting" };
}

/** @returns {string} the room that the page's address names, or the public one */
export function roomOfAddress() {
  return new URLSearchParams(window.location.search).get("room") || MAIN_ROOM;
}

/** Makes the room the page's address; the browser's Back leads to the previous room. @param {string} room */
export function putIntoAddress(room) {
  const { pathname, search } = window.location;
  const language = new URLSearchParams(search).get("language");
  const kept = new URLSearchParams({ ...(language && { language }), ...(room !== MAIN_ROOM && { room }) });
  const address = kept.size ? `?${kept}` : pathname;
  const { state } = window.history; // that of an open drawer, which Back closes first
  if (state) window.history.replaceState(null, "", address);
  else window.history.pushState(null, "", address);
  if (state) window.history.pushState(state, "", address);
}

/**
 * @param {TableChoice} choice
 * @param {string | null} mainBoard the main room's board, null while unknown
 * @param {Visited} visited the rooms opened before
 * @returns {Promise<string>} the room's ID; rejects if the server refuses the board
 */
export async function findTable(choice, mainBoard, visited) {
  const name = boardName(choice);
  if (isOwn(choice)) return roomOf(name, mainBoard, choice.knock);
  const preset = /** @type {BoardReply} */ (await getJson(`boards/${encodeURIComponent(name)}`));
  const registered = await postJson("boards", transported(preset.board, choice));
  const { digest } = /** @type {BoardReply} */ (registered);
  const key = choice.knock ? `${digest}+knock` : digest;
  const known = visited.rooms[key];
  if (known && (await isOpen(known))) return known;
  const mode = choice.knock ? "interacting" : "independent";
  const { id } = /** @type {RoomReply} */ (await postJson("rooms", { board: digest, mode }));
  visited.remember(key, id);
  return id;
}

/**
 * Returns a visitor whose address names no room to the room visited last, if it still exists.
 * @param {Visited} visited
 */
export async function leadBack({ room }) {
  const asked = new URLSearchParams(window.location.search);
  if (asked.get("room") || !room || room === MAIN_ROOM) return;
  // Without a server we stay in the main room, which reports the lost connection and retries.
  if (!(await isOpen(room).catch(() => false))) return;
  asked.set("room", room);
  window.history.replaceState(null, "", `?${asked}`);
}

/** Searches the list of rooms: requesting a room that is gone would be an error. @param {string} id */
async function isOpen(id) {
  const query = new URLSearchParams({ id });
  const { rooms } = /** @type {RoomList} */ (await getJson(`rooms?${query}`));
  return rooms.length > 0;
}
