// The picture before anybody plays: the board has the whole frame, and demo balls fall, which are neither sent nor counted.

import { randomSeed } from "../model/seed.js";
import { DemoBalls } from "../play/show/demo-balls.js";
import { byId } from "../util/dom.js";

/** @import { Hello } from "../model/messages.js" */
/** @import { Scene } from "../model/scene.js" */
/** @import { Table } from "../model/table/table.js" */

const QUIET_MS = 5000; // before the first demo ball

/** Whether the stage is idle, and its demo. */
export class Idle {
  /** When it became idle, ms; null while it is not. @type {number | null} */
  #since = null;
  /** @type {DemoBalls | null} */
  #demo = null;

  /** @param {() => void} wake draws the page again */
  constructor(wake) {
    this.wake = wake;
  }

  /**
   * @param {boolean} idle whether nothing falls and nothing is listed
   * @param {number} nowMs
   * @param {{hello: Hello, table: Table} | null} at null while there is no demo, such as with reduced motion
   * @returns {Scene | null} with demo balls
   */
  sceneAt(idle, nowMs, at) {
    document.documentElement.toggleAttribute("data-idle", idle);
    if (!idle || !at?.table.solve) {
      this.#since = null;
      this.#demo = null;
    } else if (this.#since === null) {
      this.#since = nowMs;
      window.setTimeout(this.wake, QUIET_MS);
    } else if (nowMs - this.#since >= QUIET_MS) {
      this.#demo ??= new DemoBalls(at.hello, at.table.solve, randomSeed);
    }
    const scene = this.#demo?.sceneAt(nowMs) ?? null;
    if (!scene) this.#demo = null; // the next ones begin with the next picture
    byId("demo-mark").hidden = scene === null;
    return scene;
  }

  /** Whether demo balls fall. */
  get moves() {
    return this.#demo !== null;
  }
}
