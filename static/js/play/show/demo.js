// Demo balls: over a quiet table some fall in this page alone, until somebody plays. Nothing counts or tells them.

import { Table } from "../../model/table/table.js";
import { byId } from "../../util/dom.js";
import { randomSeed } from "../room.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Solve } from "../../model/table/table.js" */
/** @import { Game } from "../game.js" */

const KEY = "plinko.demo.1";
const QUIET_MS = 5000; // before the first
const EVERY_MS = 1800;
const BALLS = 12; // then the table rests

/** The balls, on a table of their own whose clock is the page's. Pure but for chance. */
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
    this.table.applyLanded({ type: "landed", ball: ball.id, digest: ball.solved?.solved.digest ?? "" });
  }
}

/**
 * Begins over a table that stays quiet, ends with the first ball of anybody's, and then never comes back to it.
 * @param {Game} game
 * @returns {(nowMs: number, table: Table | null, still: boolean) => Scene | null} null while there is no demo;
 *   table: the real one; still: nothing is to move
 */
export function offerDemo(game) {
  const wanted = byId("demo", HTMLInputElement);
  /** @type {DemoBalls | null} */
  let balls = null;
  let timer = 0;
  let digest = "";
  /** Waits for the table to have been quiet; null once somebody has played. @type {(() => void) | null} */
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
    if (hello.board_digest === digest) return; // a line that came back
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
