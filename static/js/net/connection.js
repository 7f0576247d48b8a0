// One socket that comes back by itself. Knows nothing of balls and nothing of drawing.

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
const GROWTH = 1.7;
const DO_NOT_RETURN = 4004; // close code: there is no such room
const COME_BACK = 1012; // close code: the room goes on at another server, or this one starts again
const SILENCE_MS = 8000; // without a word while an answer is due, the line is taken for dead
const ASK_MS = SILENCE_MS / 2; // by then the server is asked for a sign of life

/** The code of an error that says no more than that: the line ends with it, and comes back. */
export const ROOM_MOVED = "room-moved";

/**
 * @typedef {object} Listener
 * @property {(text: string) => void} onText
 * @property {(bytes: ArrayBuffer) => void} onBytes
 * @property {(waitMs: number) => void} onLost it will try again after waitMs
 * @property {(reason: string) => void} onRefused the server said not to come back
 * @property {() => void} [onQuiet] nothing came for a while though news is expected: time to ask
 */

/** A socket with back-off, immediate retry when the network returns, and a dead-line watch. */
export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #wait = FIRST_WAIT_MS;
  #retryTimer = 0;
  #watchTimer = 0;
  #closed = false;
  #sentOn = false; // and not greeted since
  /** Whether the line must not stay silent now. */
  expecting = false;
  /** Bytes of all messages so far, over all sockets. */
  received = 0;

  /** @param {string} url @param {Listener} listener */
  constructor(url, listener) {
    this.url = url;
    this.listener = listener;
    this.retryNow = this.retryNow.bind(this);
    window.addEventListener("online", this.retryNow);
    document.addEventListener("visibilitychange", this.retryNow);
    this.#connect();
  }

  /** @param {object} message @returns {boolean} false when there is no open socket: not sent */
  send(message) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return false;
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** To be called once the server has greeted: only then is the line known to work. */
  settled() {
    this.#wait = FIRST_WAIT_MS;
    this.#sentOn = false;
  }

  /**
   * While true, a silent line is dropped and made anew. An idle room may stay silent for hours.
   * @param {boolean} expected
   */
  expectNews(expected) {
    clearTimeout(this.#watchTimer);
    this.#watchTimer = 0;
    this.expecting = expected;
    if (expected) this.#watchTimer = setTimeout(() => this.#ask(), ASK_MS);
  }

  /** Tries at once when it was waiting to try. */
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
    this.received += sizeOf(data);
    if (this.expecting) this.expectNews(true);
    if (typeof data === "string") this.listener.onText(data);
    else this.listener.onBytes(data);
  }

  #ask() {
    this.#watchTimer = setTimeout(() => this.#abandon(), SILENCE_MS - ASK_MS);
    this.listener.onQuiet?.();
  }

  #abandon() {
    this.#release()?.close();
    this.#lost();
  }

  /** @param {CloseEvent} closeEvent */
  #ended({ code, reason }) {
    if (code === COME_BACK && !this.#sentOn) {
      this.#sentOn = true; // once: a server that sends us on and on is none
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
    // Spread, so that a room full of players does not come back in the same millisecond.
    const wait = this.#wait * (0.75 + 0.5 * Math.random());
    this.#wait = Math.min(LONGEST_WAIT_MS, this.#wait * GROWTH);
    this.#retryTimer = setTimeout(() => this.#connect(), wait);
    this.listener.onLost(wait);
  }

  #release() {
    const socket = this.#socket;
    this.#socket = null;
    if (socket) {
      socket.onmessage = null;
      socket.onclose = null;
    }
    return socket;
  }
}

/** @param {string | ArrayBuffer} data @returns {number} bytes on the wire, without framing */
function sizeOf(data) {
  if (typeof data !== "string") return data.byteLength;
  // Plain text, as good as always, has a byte a letter.
  return /^[\x00-\x7f]*$/.test(data) ? data.length : new TextEncoder().encode(data).length;
}
