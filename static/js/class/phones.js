// The class's room: pupils drop balls on their phones, and the projector's board has them all.

import { getJson, messageOf, postJson, SEEDS, socketUrl } from "../net/api.js";
import { Connection } from "../net/connection.js";
import { decodeEvents } from "../net/protocol.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";

/** @import { Board } from "../model/board.js" */
/** @import { BriefAccepted, Hello, TableMessage } from "../model/messages.js" */
/** @import { RoomReply } from "../net/replies.js" */

/**
 * @typedef {object} Feed what a page receives of its room
 * @property {(hello: Hello) => void} onHello
 * @property {(accepted: BriefAccepted) => void} onBall
 * @property {(here: number) => void} onHere how many phones are in the room
 * @property {(text: string) => void} onTrouble
 */

/** @param {string} room @param {object} appear the message that follows the hello @param {Feed} feed @returns {Connection} */
export function joinRoom(room, appear, { onHello, onBall, onHere, onTrouble }) {
  /** @param {TableMessage} event */
  const take = (event) => {
    switch (event.type) {
      case "hello":
        connection.settled();
        connection.send({ type: "appear", ...appear });
        onHello(event);
        break;
      case "accepted": onBall(event); break;
      case "presence": onHere(event.here); break;
      case "error": onTrouble(event.detail); break;
    }
  };
  const connection = new Connection(socketUrl(room, SEEDS), {
    onText: (text) => decodeEvents(text).forEach((event) => take(/** @type {TableMessage} */ (event))),
    onBytes: () => {},
    onLost: () => onTrouble(t("stage.lost")),
    onRefused: () => onTrouble(t("class.closed")),
    onForeign: onTrouble,
  });
  return connection;
}

/** @typedef {{drops: {ball: number, seed: string, x: number | null, result: object | null}[]}} LogReply of GET rooms/…/log */

/** An open room for the class. @typedef {{reset: (board: Board) => Promise<unknown>}} Phones it begins again with a board */

/**
 * Opens a room and shows how phones join it.
 * @param {Board} board
 * @param {{onBall: (seed: string, x: number | null) => void, onPast: (drops: {seed: string, x: number | null}[]) => void}}
 *   receiver onPast: called with the drops that have landed, after a change of the board or a lost connection
 * @returns {Promise<Phones>}
 */
export async function openPhones(board, { onBall, onPast }) {
  const { id, token } = /** @type {RoomReply} */ (await postJson("rooms", { board }));
  const path = `rooms/${encodeURIComponent(id)}`;
  const link = new URL(`pupil.html?${new URLSearchParams({ room: id })}`, document.baseURI).href;
  byId("join", HTMLImageElement).src = `api/v1/${path}/qr.svg?page=pupil`;
  byId("join-link", HTMLAnchorElement).href = link;
  byId("join-link").textContent = link.replace(/^https?:\/\//, "");
  byId("join-panel").hidden = false;
  byId("join-panel").scrollIntoView();
  /** Counts hellos and resets: a log that was asked for before the last of them is out of date. */
  let state = 0;
  /** Balls that wait for the log. @type {BriefAccepted[] | null} */
  let waiting = null;
  const enter = (/** @type {{seed: string, x?: number}} */ { seed, x }) => onBall(seed, x ?? null);
  joinRoom(id, { audience: true }, {
    onHello: async ({ balls }) => {
      state += 1;
      const asked = state;
      waiting = [];
      const past = new Set();
      if (asked > 1) {
        try {
          const { drops } = /** @type {LogReply} */ (await getJson(`${path}/log`));
          if (asked !== state) return;
          const landed = drops.filter(({ result }) => result);
          onPast(landed);
          for (const { ball } of landed) past.add(ball);
        } catch (error) {
          byId("here").textContent = messageOf(error);
          if (asked !== state) return;
        }
      }
      const all = [...balls, ...waiting];
      waiting = null;
      for (const each of all) if (!past.has(each.ball)) enter(each);
    },
    onBall: (ball) => {
      if (waiting) waiting.push(ball);
      else enter(ball);
    },
    onHere: (here) => {
      byId("here").textContent = t("class.here", { n: here });
    },
    onTrouble: (text) => {
      byId("here").textContent = text;
    },
  });
  const headers = { "content-type": "application/json", authorization: `Bearer ${token}` };
  return {
    reset: (other) => {
      state += 1;
      waiting = null;
      return getJson(path, { method: "PATCH", headers, body: JSON.stringify({ board: other }) });
    },
  };
}
