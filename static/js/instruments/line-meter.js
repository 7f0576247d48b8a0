// The line to the server in numbers: tick, latency, bytes and pictures a second.

import { byId } from "../util/dom.js";
import { fixed } from "../util/format.js";


const READ_MS = 1000;
const PING_MS = 2000;
const SMOOTH = 0.3; // weight of the newest latency

/** @typedef {{tick: number | null, connection: {received: number}, ping: () => boolean}} Line */

/** Reads once a second while something moves; a sleeping room is left to sleep. */
export class LineMeter {
  #pictures = 0;
  #bytes = 0;
  #readMs = 0;
  #pingMs = 0;
  #latency = Number.NaN;
  #resting = true;

  /** A picture was drawn. */
  drawn() {
    this.#pictures += 1;
  }

  /** @param {number} ms a message there and back */
  pong(ms) {
    this.#latency = Number.isNaN(this.#latency)
      ? ms
      : this.#latency + SMOOTH * (ms - this.#latency);
    byId("latency").textContent = `${fixed(this.#latency, this.#latency < 10 ? 1 : 0)} ms`;
  }

  /** @param {Line} line @param {number} nowMs */
  read(line, nowMs) {
    if (this.#resting) return; // a ball that is down is still shown for a moment
    if (nowMs - this.#pingMs > PING_MS && line.ping()) this.#pingMs = nowMs;
    const since = nowMs - this.#readMs;
    if (since < READ_MS) return;
    const { received } = line.connection;
    if (since < 3 * READ_MS) {
      byId("received").textContent = rate((received - this.#bytes) / (since / 1000));
      byId("drawn").textContent = `${Math.round((1000 * this.#pictures) / since)} /s`;
    }
    byId("tick").textContent = String(line.tick ?? "–");
    this.#bytes = received;
    this.#pictures = 0;
    this.#readMs = nowMs;
  }

  /** Something moves again. */
  wake() {
    this.#resting = false;
  }

  /** Nothing moves: nothing comes and nothing is drawn. @param {Line} line */
  rest(line) {
    this.#resting = true;
    byId("received").textContent = rate(0);
    byId("drawn").textContent = "0 /s";
    byId("tick").textContent = String(line.tick ?? "–");
    this.#bytes = line.connection.received;
    this.#pictures = 0;
  }
}

/** @param {number} bytes a second @returns {string} */
function rate(bytes) {
  if (bytes < 1000) return `${Math.round(bytes)} B/s`;
  return `${fixed(bytes / 1000, bytes < 10_000 ? 1 : 0)} kB/s`;
}
