// A WebSocket that reconnects by itself.

import { ProtocolError } from "./protocol.js";

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
const GROWTH = 1.7;
const DO_NOT_RETURN = 4004; // close code: the room does not exist
const COME_BACK = 1012; // close code: the room moved to another server, or this server restarts
const SILENCE_MS = 8000; // after this time without an expected message, the connection is considered dead
const ASK_MS = SILENCE_MS / 2; // after this time, the listener asks the server for a reply

/** Code of the error that the server sends before it closes a connection whose room has moved. */
export const ROOM_MOVED = "room-moved";

/**
 * @typedef {object} Listener
 * @property {(text: string) => void} onText
 * @property {(bytes: ArrayBuffer) => void} onBytes
 * @property {(waitMs: number) => void} onLost the next attempt is after waitMs
 * @property {(reason: string) => void} onRefused the room does not exist: there is no further attempt
 * @property {(reason: string) => void} onForeign the server speaks another protocol: there is no further attempt
 * @property {() => void} [onQuiet] an expected message is late: send the server a ping
 */

/** A socket with back-off, an immediate attempt when the network returns, and detection of dead connections. */
export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #wait = FIRST_WAIT_MS;
  #retryTimer = 0;
  #watchTimer = 0;
  #closed = false;
  #sentOn = false; // reconnected after COME_BACK, and no hello since
  /** Whether the hello has arrived over the present socket: before, the server does not know whose messages these are. */
  greeted = false;
  /** Whether a message must arrive within SILENCE_MS. */
  expecting = false;

  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    this.retryNow = this.retryNow.bind(this);
    window.addEventListener("online", this.retryNow);
    document.addEventListener("visibilitychange", this.retryNow);
    this.#connect();
  }

  /** @param {object} message @returns {boolean} false if it was not sent, as no socket is open */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** To be called after the hello, which proves that the connection works: resets the back-off. */
  settled() {
    this.#wait = FIRST_WAIT_MS;
    this.#sentOn = false;
    this.greeted = true;
  }

  /**
   * While true, a silent connection is replaced. An idle room may be silent for hours.
   * @param {boolean} expected
   */
  expectNews(expected) {
    clearTimeout(this.#watchTimer);
    this.#watchTimer = 0;
    this.expecting = expected;
    if (expected) this.#watchTimer = setTimeout(() => this.#suspect(), ASK_MS);
  }

  /** Connects immediately if the next attempt is waiting. */
  retryNow() {
    if (this.#retryTimer === 0 || document.visibilityState === "hidden") return;
    this.#connect();
  }

  close() {
    this.#closed = true;
    this.expectNews(false);
    clearTimeout(this.#retryTimer);
    window.removeEventListener("online", this.retryNow);
    document.removeEventListener("visibilitychange", this.retryNow);
    this.#release()?.close(1000);
  }

  #connect() {
    clearTimeout(this.#retryTimer);
    this.#retryTimer = 0;
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => this.#receive(data);
    socket.onclose = (event) => this.#ended(event);
    this.#socket = socket;
  }

  /** @param {string | ArrayBuffer} data */
  #receive(data) {
    if (this.expecting) this.expectNews(true);
    try {
      if (typeof data === "string") this.listener.onText(data);
      else this.listener.onBytes(data);
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.close();
      this.listener.onForeign(error.message);
    }
  }

  /** Asks for a sign of life; without one, gives the socket up. */
  #suspect() {
    this.#watchTimer = setTimeout(() => {
      this.#release()?.close();
      this.#lost();
    }, SILENCE_MS - ASK_MS);
    this.listener.onQuiet?.();
  }

  /** @param {CloseEvent} closeEvent */
  #ended({ code, reason }) {
    if (code === COME_BACK && !this.#sentOn) {
      this.#sentOn = true; // only once without waiting: servers could send the page to and fro forever
      this.#release();
      this.expectNews(false);
      this.#connect();
      return;
    }
    if (code !== DO_NOT_RETURN) {
      this.#lost();
      return;
    }
    this.close();
    this.listener.onRefused(reason);
  }

  #lost() {
    if (this.#closed) return;
    this.#release();
    this.expectNews(false);
    // Random, so that the players of a full room do not all reconnect in the same millisecond.
    const wait = this.#wait * (0.75 + 0.5 * Math.random());
    this.#wait = Math.min(LONGEST_WAIT_MS, this.#wait * GROWTH);
    this.#retryTimer = setTimeout(() => this.#connect(), wait);
    this.listener.onLost(wait);
  }

  #release() {
    const socket = this.#socket;
    this.#socket = null;
    this.greeted = false;
    if (socket) {
      socket.onmessage = null;
      socket.onclose = null;
    }
    return socket;
  }
}
