// Takes the place of connection.js where there is no server: a room on this device, which answers the page's messages as
// a server's room does. The page computes each path itself, so a seed is all that a drop needs.

import { randomSeed } from "../model/seed.js";
import { PHYSICS_VERSION } from "../solver/digest.js";
import { getJson, messageOf, SEEDS } from "./api.js";
import { boardIn, openOnce } from "./device.js";
import { PROTOCOL } from "./protocol.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Listener } from "./connection.js" */
/** @import { BoardList, BoardReply } from "./replies.js" */

const RATE = 60; // ticks a second; a drop may enter between two
const MOST_BALLS = 200;
export const ROOM_MOVED = ""; // no room moves

/** A connection that never breaks. */
export class Connection {
  greeted = false;
  #balls = 0;
  #closed = false;
  /** @type {Hello | null} */
  #hello = null;

  /** @param {string} url of the room at a server @param {Pick<Listener, "onText" | "onRefused">} listener */
  constructor(url, listener) {
    this.room = decodeURIComponent(new URL(url).pathname.split("/").at(-1) ?? "");
    this.listener = listener;
    void this.#enter();
  }

  async #enter() {
    try {
      if (typeof WebAssembly === "undefined") throw new Error("a room on this device needs WebAssembly");
      const name = encodeURIComponent(boardIn(this.room));
      const [reply, list] = await Promise.all([getJson(`boards/${name}`), getJson("boards")]);
      const { board, digest } = /** @type {BoardReply} */ (reply);
      const listed = /** @type {BoardList} */ (list).boards.find((each) => each.digest === digest);
      this.#hello = /** @type {Hello} */ ({
        type: "hello", protocol: PROTOCOL, room: this.room, board, board_name: board.name, board_digest: digest,
        slots: board.drop.slots ?? [], mode: "independent", tick_rate: RATE, tick: this.#tick, seq: 0, stream: SEEDS,
        physics_version: PHYSICS_VERSION, limits: { balls: MOST_BALLS }, balls: /** @type {Hello["balls"]} */ ([]),
        stats: { histogram: board.bins.multipliers.map(() => 0) }, stakes: listed?.stakes ?? false,
      });
      this.#tell(this.#hello);
    } catch (error) {
      this.listener.onRefused(messageOf(error));
    }
  }

  /** The room's clock is the page's. */
  get #tick() {
    return RATE * performance.now() / 1000;
  }

  /**
   * @param {Record<string, any>} message a drop with a stake has its session, and its number there
   * @returns {boolean} false before the hello
   */
  send(message) {
    if (!this.#hello) return false;
    if (message.type === "ping") this.#tell({ type: "pong", t: message.t });
    if (message.type === "drop") void this.#drop(message, this.#hello);
    return true;
  }

  /** @param {Record<string, any>} message @param {Hello} hello */
  async #drop({ ref, seed = randomSeed(), aim, stake, session, drop }, { board }) {
    const { digest } = (await openOnce()).drop(board, { seed, aim });
    const ball = this.#balls;
    this.#balls += 1;
    const start = { ball, seed, tick: this.#tick, ...(aim !== undefined && { aim }) };
    const receipt = { session, drop, stake, ball, seed, aim: aim ?? null };
    this.#tell(
      { type: "accepted", ref, ...start, ...(session ? { stake, receipt: { receipt } } : { practice: true }) },
      { type: "landed", ball, digest },
    );
  }

  /** @param {...object} events received after `send` has returned, as over a network */
  #tell(...events) {
    queueMicrotask(() => { if (!this.#closed) this.listener.onText(JSON.stringify(events)); });
  }

  settled() {
    this.greeted = true;
  }

  /** A room on this device is never silent for too long. */
  expectNews() {}

  retryNow() {}

  close() {
    this.#closed = true;
  }
}
