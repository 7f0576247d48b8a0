// Finds or opens the room where a board is played in the world that was chosen; and its address.

import { getJson, postJson } from "../net/api.js";
import { boardName, MAIN_ROOM, readBoardName, roomOf } from "../model/presets.js";
import { isOwn, readWorldName, transported } from "../model/worlds.js";

/** @import { Visited } from "../model/player/visited.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { Choice } from "../model/presets.js" */
/** @import { World } from "../model/worlds.js" */
/** @import { BoardReply, RoomList, RoomReply } from "../net/replies.js" */

/** @typedef {Choice & World & {knock: boolean}} TableChoice knock: whether balls knock each other */

/** @param {Hello} hello @returns {TableChoice | null} what is played there; null for a board that nobody can choose here */
export function choiceOf({ board_name: name, mode }) {
  const { preset, ...world } = readWorldName(name);
  const choice = readBoardName(preset);
  return choice && { ...choice, ...world, knock: mode === "interacting" };
}

/** @returns {string} the room that the page's address names, or the public one */
export function roomOfAddress() {
  return new URLSearchParams(window.location.search).get("room") || MAIN_ROOM;
}

/** Makes it the page's address; Back leads to the one before. @param {string} room */
export function putIntoAddress(room) {
  const { pathname } = window.location;
  const address = room === MAIN_ROOM ? pathname : `?room=${encodeURIComponent(room)}`;
  window.history.pushState(null, "", address);
}

/**
 * @param {TableChoice} choice
 * @param {string | null} mainBoard the main room's board, as far as it is known
 * @param {Visited} visited remembers the rooms opened before
 * @returns {Promise<string>} the room's id; rejects with what the server has against the board
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
 * A visitor who asks for no table gets the address of the one where they were, if it is still there.
 * @param {Visited} visited
 */
export async function leadBack({ room }) {
  const asked = new URLSearchParams(window.location.search);
  if (asked.get("room") || !room || room === MAIN_ROOM) return;
  // Without a server, too, there is a table to come to: it says so, and tries again.
  if (!(await isOpen(room).catch(() => false))) return;
  asked.set("room", room);
  window.history.replaceState(null, "", `?${asked}`);
}

/** The list is asked, not the room itself: one that is gone is no error. @param {string} id */
async function isOpen(id) {
  const query = new URLSearchParams({ id });
  const { rooms } = /** @type {RoomList} */ (await getJson(`rooms?${query}`));
  return rooms.length > 0;
}
