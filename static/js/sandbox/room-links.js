// Links for a visitor whose room does not exist.

import { ApiError, getJson } from "../net/api.js";
import { t } from "../texts/text.js";
import { byId, make } from "../util/dom.js";

/** @import { RoomList } from "../net/replies.js" */

const MOST = 6; // rooms in the list

/** Links a private box and the rooms of touching balls. */
export async function showRoomLinks() {
  const list = byId("room-links");
  list.replaceChildren(way("sandbox.html", t("box.to-own")), way(addressOf("sandbox"), t("box.together")));
  list.hidden = false;
  for (const { id, board_name: name } of await openRooms()) {
    list.append(way(addressOf(id), t("box.go-to", { room: name ? `${name} (${id})` : id })));
  }
}

/** @returns {Promise<RoomList["rooms"]>} empty if the server refuses: the first two links stay */
async function openRooms() {
  try {
    const { rooms } = /** @type {RoomList} */ (await getJson(`rooms?mode=interacting&limit=${MOST}`));
    return rooms;
  } catch (error) {
    if (!(error instanceof ApiError)) throw error;
    return [];
  }
}

/** @param {string} room @returns {string} */
function addressOf(room) {
  return `sandbox.html?${new URLSearchParams({ room })}`;
}

/** @param {string} href @param {string} words @returns {HTMLElement} */
function way(href, words) {
  return make("li", {}, make("a", { href }, words));
}
