// The connection to the server in numbers: tick, latency, bytes a second, and drawn frames a second.

import { byId } from "../../util/dom.js";
import { fixed } from "../../util/format.js";

/** @import { Game } from "../game.js" */

const READ_MS = 1000;
const PING_MS = 2000;
const SMOOTH = 0.3; // weight of the newest latency

/** Updates once a second while something moves; a sleeping room is not woken by pings. */
export class LineMeter {
  #pictures = 0;
  #bytes = 0;
  #readMs = 0;
  #pingMs = 0;

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    let latency = Number.NaN;
    game.on("pong", (ms) => {
      latency = Number.isNaN(latency) ? ms : latency + SMOOTH * (ms - latency);
      byId("latency").textContent = `${fixed(latency, latency < 10 ? 1 : 0)} ms`;
    });
    game.on("room", () => { if (game.room.state !== "live") this.#tell(0, 0); });
  }

  /** Called after each drawn frame. @param {number} nowMs */
  drawn(nowMs) {
    this.#pictures += 1;
    const { room } = this.game;
    if (room.state !== "live" || !room.table?.flying) return; // a landed ball is shown for another moment
    if (nowMs - this.#pingMs > PING_MS && room.ping()) this.#pingMs = nowMs;
    const since = nowMs - this.#readMs;
    if (since < READ_MS) return;
    this.#readMs = nowMs;
    // After a pause the rates would be meaningless: they show 0.
    const seconds = since < 3 * READ_MS ? since / 1000 : Number.POSITIVE_INFINITY;
    this.#tell((room.connection.received - this.#bytes) / seconds, this.#pictures / seconds);
  }

  /** @param {number} bytes a second @param {number} pictures frames a second */
  #tell(bytes, pictures) {
    const { tick, connection } = this.game.room;
    const [size, unit] = bytes < 1000 ? [bytes, "B/s"] : [bytes / 1000, "kB/s"];
    byId("received").textContent = `${fixed(size, unit === "kB/s" && size < 10 ? 1 : 0)} ${unit}`;
    byId("drawn").textContent = `${Math.round(pictures)} /s`;
    byId("tick").textContent = String(tick ?? "–");
    this.#bytes = connection.received;
    this.#pictures = 0;
  }
}
