// The balls of the demo.

import { Table } from "../../model/table/table.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Solve } from "../../model/table/table.js" */

const EVERY_MS = 1800;
const BALLS = 12; // then the demo ends

/** The demo's balls, on a separate table that runs on the page's clock. Pure but for random seeds. */
export class DemoBalls {
  #count = 0;
  #nextMs = 0;

  /** @param {Hello} hello @param {Solve} solve @param {() => string} draw a seed */
  constructor({ board, tick_rate }, solve, draw) {
    this.table = new Table({ board, tick_rate, tick: 0, stream: "seeds", balls: [] }, solve);
    this.draw = draw;
  }

  /** @param {number} nowMs @returns {Scene | null} null once all have landed */
  sceneAt(nowMs) {
    const { table } = this;
    const t = nowMs / 1000;
    if (this.#count < BALLS && nowMs >= this.#nextMs) this.#drop(nowMs);
    table.settle(t, t);
    const scene = table.sceneAt(t, t);
    return this.#count < BALLS || table.busy ? scene : null;
  }

  /** @param {number} nowMs */
  #drop(nowMs) {
    this.#nextMs = nowMs + EVERY_MS;
    this.#count += 1;
    const tick = (nowMs / 1000) * this.table.rate;
    const ball = this.table.accept({ type: "accepted", ball: this.#count, seed: this.draw(), tick }, false);
    this.table.applyLanded({ type: "landed", ball: ball.id, digest: ball.solved?.digest ?? "" });
  }
}
