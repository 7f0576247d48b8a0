// Draws the room and plays its sound while something moves: board, balls, trails, tray, and the light of a landing.

import { BoardView } from "../../board/view.js";
import { emptyScene } from "../../model/scene.js";
import { FrameLoop } from "../../util/frame-loop.js";
import { followPointer } from "../desk/pointer.js";
import { showNotices } from "../panels/notices.js";
import { showTray } from "../panels/tray.js";
import { offerSound } from "../sound/choice.js";
import { offerDemo } from "./demo.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { Table } from "../../model/table/table.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */
/** @import { FitMeter } from "../panels/fit.js" */
/** @import { Show } from "./show.js" */

/** Everything drawn and played of a room. */
export class BoardScreen {
  #digest = "";
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  /** Loaded with the first ball. @type {Show | null} */
  #show = null;
  /** Measures once the Lab has been opened. @type {FitMeter | null} */
  instruments = null;

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.tray = showTray(game, theme);
    this.view = new BoardView(theme, (geometry) => {
      this.tray.histogram.layOut(geometry);
      this.#show?.layOut();
      wake();
    });
    this.watch = showNotices(game, theme);
    this.demo = offerDemo(game);
    this.sound = offerSound(game);
    this.hover = followPointer(game, this.view);
    this.#subscribe(wake);
    document.addEventListener("visibilitychange", wake);
  }

  /** @param {() => void} wake */
  #subscribe(wake) {
    const { game } = this;
    for (const kind of /** @type {const} */ (["picture", "room", "choice"])) game.on(kind, wake);
    game.on("table", ({ hello, table }) => this.#setTable(hello, table));
    game.on("seen", (played) => this.#seen(played));
    let falling = 0;
    game.on("run", () => {
      if (game.falling > falling) {
        this.sound.ask();
        void this.loadShow(); // a ball falls without it, too, as when the server is away
      }
      falling = game.falling;
    });
    game.on("hit", () => this.loadShow());
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable(hello, table) {
    const { board, board_digest: digest, slots } = hello;
    const { histogram } = this.tray;
    const expected = this.#digest === digest ? histogram.expected : null;
    // After a reconnect the board is usually the same.
    if (this.#digest !== digest) {
      this.#digest = digest;
      this.view.setBoard(board, slots);
    }
    table.tracing = this.#still.matches;
    histogram.setBoard(board, hello.stats.histogram, expected);
    this.loop.wake();
  }

  /** @returns {Promise<Show | null>} null if its code cannot be fetched; the next ball tries again */
  async loadShow() {
    const code = await import("./show.js").catch(() => null);
    if (code) this.#show ??= new code.Show(this.game, this.theme, this.view, this.#still);
    return this.#show;
  }

  /** Our drop's landing was shown. @param {Played} played */
  async #seen(played) {
    const { bin, score } = played;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin !== null) this.sound.sound()?.chime(score, (bin + 0.5) / this.tray.histogram.counts.length);
    (await this.loadShow())?.see(played);
  }

  /** @param {number} now ms */
  #draw(now) {
    const { game, view, instruments } = this;
    const { room } = game;
    const { table } = room;
    const t = room.time(now);
    const still = this.#still.matches;
    room.settle(still ? Number.POSITIVE_INFINITY : t, now);
    const demo = this.demo(now, table, still);
    const scene = demo ?? table?.sceneAt(t, now / 1000) ?? emptyScene();
    if (table) this.sound.sound()?.hear(table.heard, t);
    this.watch();
    const showing = this.#show?.dress(scene, now) ?? false;
    // With reduced motion the path of our last ball replaces the moving ball.
    const way = table?.lastTrace;
    if (still) Object.assign(scene, { balls: [], flashes: [], paths: way ? [way] : [] });
    scene.aim = this.hover() ?? game.choice.aim;
    view.draw(scene);
    const tray = this.tray.show(now, still);
    const measuring = instruments?.show(this.tray.histogram.counts, now) ?? false;
    return (table?.busy ?? false) || tray || measuring || showing || demo !== null;
  }
}
