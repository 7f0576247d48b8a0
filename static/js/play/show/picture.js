// Draws the room and plays its sound while something moves: board, balls, trails, tray, and the light of a landing.

import { BoardView } from "../../board/view.js";
import { describeBoard } from "../../board/alternative-text.js";
import { announceShape } from "../../board/shape.js";
import { emptyScene } from "../../model/scene.js";
import { ratioOf } from "../../paint/geometry.js";
import { byId } from "../../util/dom.js";
import { FrameLoop } from "../../util/frame-loop.js";
import { followPointer } from "../desk/pointer.js";
import { InstrumentPanel } from "../panels/instruments.js";
import { showNotices } from "../panels/notices.js";
import { showTray } from "../panels/tray.js";
import { Sound } from "../sound/sound.js";
import { offerSound } from "../sound/choice.js";
import { offerDemo } from "./demo.js";
import { Encore } from "./encore.js";
import { Ghost } from "./ghost.js";
import { Moment, WIN } from "./moment.js";
import { nearMiss } from "./near-miss.js";
import { Streaks } from "./streaks.js";

/** @import { Point } from "../../model/board.js" */
/** @import { Hello } from "../../model/messages.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { Solved } from "../../model/table/path-feed.js" */
/** @import { Table } from "../../model/table/table.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

/** Everything drawn and played of a room. */
export class Picture {
  #digest = "";
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  /** A win to celebrate after the zoom. @type {Played | null} */
  #won = null;
  #encore = new Encore();
  #streaks = new Streaks();

  /** @param {Game} game @param {Theme} theme */
  constructor(game, theme) {
    this.game = game;
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.tray = showTray(game, theme);
    this.ghost = new Ghost(byId("board-ghost", HTMLCanvasElement), theme);
    const canvases = {
      still: byId("board-still", HTMLCanvasElement), moving: byId("board-moving", HTMLCanvasElement),
    };
    this.view = new BoardView(canvases, theme, (geometry) => {
      this.tray.histogram.layOut(geometry);
      this.ghost.layOut(geometry);
      wake();
    });
    this.watch = showNotices(game, theme);
    this.moment = new Moment(theme, this.view);
    this.demo = offerDemo(game);
    this.sound = new Sound();
    this.offerSound = offerSound(this.sound, game.storage);
    this.instruments = new InstrumentPanel(game, theme);
    this.hover = followPointer(game, this.view, (x, y) => this.instruments.pick(x, y));
    this.#subscribe(wake);
    theme.onChange(() => {
      this.view.repaint();
      this.ghost.recolour();
      wake();
    });
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
      if (game.falling > falling) this.#dropped();
      falling = game.falling;
    });
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable(hello, table) {
    const { board, board_digest: digest, slots } = hello;
    // After a reconnect the board is usually the same.
    if (this.#digest !== digest) {
      this.#digest = digest;
      announceShape(ratioOf(board));
      this.ghost.setBoard(board);
      this.sound.setBoard(board);
      this.view.setBoard(board, slots);
      this.view.moving.setAttribute("aria-label", describeBoard(board));
    }
    this.#streaks.clear();
    this.#encore.clear();
    this.moment.hide();
    this.#won = null;
    table.onPassed = this.ghost.follow;
    table.tracing = this.#still.matches;
    this.tray.histogram.setBoard(board, hello.stats.histogram, this.instruments.fit.expected);
    this.loop.wake();
  }

  /** Our next ball falls: clears what is shown of the last landing. An auto-drop leaves a win's card its time. */
  #dropped() {
    this.offerSound();
    if (!this.game.auto) this.moment.hide();
    if (!this.#encore.looking) this.#encore.clear();
  }

  /** Our drop's landing was shown. @param {Played} played */
  #seen(played) {
    const { bin, score } = played;
    const { game } = this;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin !== null) this.sound.chime(score, (bin + 0.5) / this.tray.histogram.counts.length);
    const still = this.#still.matches;
    const looked = document.visibilityState !== "hidden";
    const last = looked && game.room.own.unseen === 0 && !game.auto;
    const drop = this.#solve(played);
    const { board, solve } = game.room.table ?? {};
    if (drop && game.choice.pace === "instant" && !still) this.#streaks.add(drop);
    const won = looked && bin !== null && score >= WIN;
    if (drop && board && solve && bin !== null && (last || won) && !this.#encore.looking) {
      this.#encore.begin(drop, board, (x) => solve({ seed: "0", x }), still);
    }
    if (won && (!this.#won || score > this.#won.score)) this.#won = played;
    if (last && drop && board && bin !== null && !won) {
      // How close the ball came to a better bin stands next to its payout.
      byId("near").textContent = nearMiss(board, bin, drop.xEnd);
      byId("near").hidden = byId("near").textContent === "";
    }
    this.loop.wake();
  }

  /** @param {Played} played @returns {Solved | null} null if this page cannot compute it */
  #solve({ seed, x, aim, knocked }) {
    const { table } = this.game.room;
    if (knocked || !table?.solve) return null;
    return table.solve(x === null ? { seed, aim: aim ?? undefined } : { seed, x });
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
    if (table?.growsWhenDrawn) instruments.ball.measure();
    if (table) this.sound.hear(table.heard, t);
    this.watch();
    const lab = document.documentElement.dataset.drawer === "lab";
    const streaking = this.#streaks.show(scene, now / 1000);
    const encore = this.#encore.show(scene, now / 1000, still, lab);
    this.#look(this.#encore.near);
    if (this.#won && !this.#encore.looking) {
      this.moment.celebrate(this.#won, still);
      this.#won = null;
    }
    const celebrating = this.moment.show(now);
    // With reduced motion the path of our last ball replaces the moving ball.
    const way = table?.lastTrace?.points();
    if (still) Object.assign(scene, { balls: [], flashes: [], paths: way ? [way] : [] });
    scene.aim = this.hover() ?? game.choice.aim;
    scene.chosen = instruments.open ? instruments.ball.chosen : null;
    view.draw(scene);
    this.ghost.paint(now);
    const tray = this.tray.show(now, still);
    const measuring = instruments.show(this.tray.histogram.counts, now);
    return (table?.busy ?? false) || this.ghost.pending || tray || measuring || encore || streaking || celebrating
      || this.#won !== null || demo !== null;
  }

  /** Zooms in on a point of the board, or out again. @param {Point | null} place m; null zooms out */
  #look(place) {
    const { geometry, box } = this.view;
    box.classList.toggle("near", place !== null);
    if (!place || !geometry) return;
    box.style.setProperty("--near-x", `${geometry.px(place.x)}px`);
    box.style.setProperty("--near-y", `${geometry.py(place.y)}px`);
  }
}
