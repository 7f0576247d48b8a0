// Finds or opens the room where a board is played in the world that was chosen.

import { getJson } from "../net/api.js";
import { boardName, roomOf } from "../model/presets.js";
import { isOwn, transported } from "../model/worlds.js";

const JSON_HEADERS = { "content-type": "application/json" };

/**
 * @param {import("./input/controls.js").TableChoice} choice
 * @param {string | null} mainBoard the main room's board, as far as it is known
 * @param {import("../model/session.js").Session} session remembers the rooms opened before
 * @returns {Promise<string>} the room's id; rejects with what the server has against the board
 */
export async function findTable(choice, mainBoard, session) {
  const name = boardName(choice);
  if (isOwn(choice)) return roomOf(name, mainBoard, choice.knock);
  const { board } = await getJson(`boards/${encodeURIComponent(name)}`);
  const body = JSON.stringify(transported(board, choice));
  const { digest } = await getJson("boards", { method: "POST", headers: JSON_HEADERS, body });
  const key = choice.knock ? `${digest}+knock` : digest;
  const known = session.rooms[key];
  if (known && (await isOpen(known))) return known;
  const opened = await getJson("rooms", {
    method: "POST",
    headers: JSON_HEADERS,
    body: JSON.stringify({ board: digest, mode: choice.knock ? "interacting" : "independent" }),
  });
  session.remember(key, opened.id);
  return opened.id;
}

/** The list is asked, not the room itself: one that is gone is no error. */
async function isOpen(id) {
  const { rooms } = await getJson("rooms");
  return rooms.some((room) => room.id === id);
}
