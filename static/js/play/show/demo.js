// Demo balls: they fall in a quiet room, only in this page, until somebody plays. They are neither counted nor sent.

import { Table } from "../../model/table/table.js";
import { byId } from "../../util/dom.js";
import { randomSeed } from "../room.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Solve } from "../../model/table/table.js" */
/** @import { Game } from "../game.js" */

const KEY = "plinko.demo.1";
const QUIET_MS = 5000; // before the first ball
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

/**
 * Begins in a room that stays quiet, and ends for good in that room with anybody's first ball.
 * @param {Game} game
 * @returns {(nowMs: number, table: Table | null, still: boolean) => Scene | null} null while there is no demo;
 *   table: the real one; still: whether motion is reduced
 */
export function offerDemo(game) {
  const wanted = byId("demo", HTMLInputElement);
  /** @type {DemoBalls | null} */
  let balls = null;
  let timer = 0;
  let digest = "";
  /** Starts waiting for a quiet time; null once somebody has played. @type {(() => void) | null} */
  let wait = null;

  const hide = () => {
    window.clearTimeout(timer);
    balls = null;
    byId("demo-mark").hidden = true;
  };
  const end = () => {
    wait = null;
    hide();
  };
  /** @param {Hello} hello @param {Solve} solve */
  const begin = (hello, solve) => {
    if (!wanted.checked || document.visibilityState === "hidden") return;
    balls = new DemoBalls(hello, solve, randomSeed);
    byId("demo-mark").hidden = false;
    game.tell("picture", null);
  };
  wanted.checked = game.storage.getItem(KEY) !== "off";
  wanted.addEventListener("change", () => {
    game.storage.setItem(KEY, wanted.checked ? "on" : "off");
    if (wanted.checked) wait?.();
    else hide();
  });
  game.on("table", ({ hello, table: { solve, flying } }) => {
    if (hello.board_digest === digest) return; // a reconnect
    digest = hello.board_digest;
    end();
    if (!solve || flying) return;
    wait = () => {
      window.clearTimeout(timer);
      timer = window.setTimeout(() => begin(hello, solve), QUIET_MS);
    };
    wait();
  });
  return (nowMs, table, still) => {
    if ((wait || balls) && (table?.flying || still)) end();
    const scene = balls?.sceneAt(nowMs) ?? null;
    if (balls && !scene) end();
    return scene;
  };
}
