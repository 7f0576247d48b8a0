// Demo balls: over a quiet table some fall in this page alone, until somebody plays. Nothing counts or tells them.

import { Table } from "../../model/table/table.js";
import { byId } from "../../util/dom.js";
import { randomSeed } from "../room.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Ball, Solve } from "../../model/table/table.js" */
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
    this.table.applyLanded({ type: "landed", ball: ball.id, digest: digestOf(ball) });
  }
}

/** @param {Ball} ball */
function digestOf({ solved }) {
  return solved?.solved.digest ?? "";
}

/** Begins over a table that stays quiet, ends with the first ball of anybody's, and then never comes back to it. */
export class Demo {
  /** @type {DemoBalls | null} */
  #balls = null;
  #timer = 0;
  #digest = "";
  /** Waits for the table to have been quiet; null once somebody has played. @type {(() => void) | null} */
  #wait = null;

  /** @param {Game} game */
  constructor(game) {
    const { storage } = game;
    this.game = game;
    this.wanted = byId("demo", HTMLInputElement);
    this.wanted.checked = storage.getItem(KEY) !== "off";
    this.wanted.addEventListener("change", () => {
      storage.setItem(KEY, this.wanted.checked ? "on" : "off");
      if (this.wanted.checked) this.#wait?.();
      else this.#hide();
    });
    game.on("table", ({ hello, table }) => this.#setTable(hello, table));
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable(hello, { solve, flying }) {
    if (hello.board_digest === this.#digest) return; // a line that came back
    this.#digest = hello.board_digest;
    this.end();
    if (!solve || flying) return;
    this.#wait = () => {
      window.clearTimeout(this.#timer);
      this.#timer = window.setTimeout(() => this.#begin(hello, solve), QUIET_MS);
    };
    this.#wait();
  }

  /** @param {Hello} hello @param {Solve} solve */
  #begin(hello, solve) {
    if (!this.wanted.checked || document.visibilityState === "hidden") return;
    this.#balls = new DemoBalls(hello, solve, randomSeed);
    byId("demo-mark").hidden = false;
    this.game.tell("picture", null);
  }

  end() {
    this.#wait = null;
    this.#hide();
  }

  #hide() {
    window.clearTimeout(this.#timer);
    this.#balls = null;
    byId("demo-mark").hidden = true;
  }

  /**
   * @param {number} nowMs @param {Table | null} table the real one @param {boolean} still nothing is to move
   * @returns {Scene | null} null while there is no demo
   */
  sceneAt(nowMs, table, still) {
    if ((this.#wait || this.#balls) && (table?.flying || still)) this.end();
    const scene = this.#balls?.sceneAt(nowMs) ?? null;
    if (this.#balls && !scene) this.end();
    return scene;
  }
}
