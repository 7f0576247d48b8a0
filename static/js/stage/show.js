// Shows a room to an audience: the board as large as possible, the last winners, the leaders. Nothing to click.

import { BoardView } from "../board/view.js";
import { emptyScene } from "../model/scene.js";
import { FairPlay } from "../play/fairness/fair-play.js";
import { called, paidMark, swatch } from "../play/panels/list-marks.js";
import { Room } from "../play/room.js";
import { Sound } from "../play/sound/sound.js";
import { Store } from "../play/store.js";
import { Wallet } from "../play/account/wallet.js";
import { swatchOf } from "../model/table/visitors.js";
import { t } from "../texts/text.js";
import { byId, make } from "../util/dom.js";
import { plain } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { Figures } from "./figures.js";
import { Idle } from "./idle.js";
import { Leaders } from "./leaders.js";
import { StageTray } from "./tray.js";

/** @import { Hello, QueueState } from "../model/messages.js" */
/** @import { Landing } from "../model/table/visitors.js" */
/** @import { Table } from "../model/table/table.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Leader } from "./leaders.js" */
/** @import { LineState } from "../play/room.js" */
/** @import { Key } from "../texts/text.js" */
/** @import { Rank, StageOptions } from "./options.js" */

const QUEUED = 2; // items shown of the queue
const NOTHING_WAITS = { waiting: 0, paused: false, items: [] };
const SHOWN = 5; // rows in each list; the style sheet hides some where space is short
/** What is said of the connection. @type {Partial<Record<LineState, Key>>} */
const STATES = { closed: "stage.no-room", full: "stage.full", reconnecting: "stage.lost" };
const AGAIN_MS = 30_000; // after a refusal: by then the room or the server may exist again

/** The audience does not play: there is no fair session, and nothing is stored in the browser. */
class NoSession extends FairPlay {
  greeted() {
    this.failed = true;
  }
}

/** @type {Pick<Storage, "getItem" | "setItem" | "removeItem">} */
const NOTHING_KEPT = { getItem: () => null, setItem: () => {}, removeItem: () => {} };

/** The page. */
export class Show {
  #digest = "";
  #leaders = new Leaders();
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");

  /** @param {StageOptions} options @param {{theme: Theme, solver: Solver | null, streams: string[]}} parts */
  constructor(options, { theme, solver, streams }) {
    this.options = options;
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.idle = new Idle(wake);
    this.figures = new Figures(options.room);
    const around = options.ground === null;
    const news = this.#subscribed(wake);
    this.tray = options.tray && new StageTray(options, theme, news);
    this.view = new BoardView(theme, (geometry) => {
      this.tray?.histogram.layOut(geometry);
      wake();
    }, { around, plate: options.plate });
    this.sound = options.sound ? soundOf(news) : null;
    byId("winners-panel").hidden = !options.winners;
    byId("leaders-panel").hidden = options.leaders === null;
    byId("queue-panel").hidden = !options.queue;
    if (options.join) showWay(options.room);
    this.room = new Room(options.room, {
      news, streams, solver, wallet: new Wallet(NOTHING_KEPT), self: null,
      fair: (send) => new NoSession(options.room, NOTHING_KEPT, news, send),
    });
    document.addEventListener("visibilitychange", wake);
  }

  /** @param {() => void} wake */
  #subscribed(wake) {
    const news = new Store();
    news.on("picture", wake);
    news.on("table", ({ hello, table }) => this.#setTable(hello, table));
    news.on("show", () => void this.figures.load());
    news.on("queue", (queue) => this.#showQueue(queue));
    news.on("landed", (landing) => this.#landed(landing));
    news.on("room", () => {
      this.#showState();
      wake();
    });
    return news;
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable(hello, table) {
    const { board, board_digest: digest, slots } = hello;
    table.tracing = this.#still.matches;
    this.#showQueue(NOTHING_WAITS); // a room with a queue sends its state right after the hello
    if (this.#digest !== digest) {
      this.#digest = digest;
      document.title = t("stage.title-board", { board: board.name });
      this.view.setBoard(board, slots);
      this.#leaders.clear();
      this.room.visitors.landings = [];
      this.#list();
    }
    this.tray?.setTable(hello);
    void this.figures.load();
    this.loop.wake();
  }

  #showState() {
    const { state } = this.room;
    document.documentElement.dataset.state = state;
    const words = STATES[state];
    byId("result").textContent = words ? t(words) : "";
    // On a projector nobody reloads the page.
    if (state === "closed") window.setTimeout(() => window.location.reload(), AGAIN_MS);
  }

  /** @param {Landing} landing */
  #landed(landing) {
    const { board } = this.view;
    if (!board) return;
    document.documentElement.dataset.lastBin = String(landing.bin ?? "none");
    if (landing.bin !== null) {
      this.sound?.chime(landing.score, (landing.bin + 0.5) / board.bins.multipliers.length);
    }
    this.#leaders.note(landing, board);
    this.#list();
  }

  #list() {
    const { winners, leaders } = this.options;
    const landings = winners ? this.room.visitors.landings.slice(0, SHOWN) : [];
    fill("winners", landings.map((landing) => this.#row(landing, this.#paid(landing))));
    const best = leaders ? this.#leaders.top(leaders, SHOWN) : [];
    fill("leaders", best.map((leader) => this.#leader(leader, /** @type {Rank} */ (leaders))));
  }

  /** @param {Pick<QueueState, "waiting" | "paused" | "items">} queue */
  #showQueue({ waiting, paused, items }) {
    byId("queue-title").textContent = t(paused ? "stage.queue-paused" : "stage.queue", { n: waiting });
    fill("queue", items.slice(0, QUEUED).map((item) => {
      const { name, left } = item;
      const colour = item.colour ?? (name ? swatchOf(item) : this.theme.palette.other);
      return make("li", {}, swatch(colour), make("bdi", {}, called({ name })), make("span", { class: "count" }, plain(left)));
    }));
  }

  /** @param {Leader} leader @param {Rank} rank */
  #leader({ best, prize, balls, prizes }, rank) {
    if (rank === "balls") return this.#row(best, make("span", { class: "count" }, plain(balls)));
    if (rank === "best" || !prize) return this.#row(best, this.#paid(best));
    return this.#row(prize, make("span", { class: "count" }, plain(prizes)));
  }

  /** @param {Landing} landing */
  #paid({ bin, score }) {
    return paidMark(this.theme, this.view.board, bin, score);
  }

  /** @param {Landing} landing @param {HTMLElement} told its last cell */
  #row({ owner }, told) {
    const colour = owner ? swatchOf(owner) : this.theme.palette.other;
    return make("li", {}, swatch(colour), make("bdi", {}, called(owner)), told);
  }

  /** @param {number} now ms */
  #draw(now) {
    const { table } = this.room;
    const time = this.room.time(now);
    const still = this.#still.matches;
    this.room.settle(still ? Number.POSITIVE_INFINITY : time, now);
    const demo = this.#demo(now, still);
    const scene = demo ?? table?.sceneAt(time, now / 1000) ?? emptyScene();
    if (table) this.sound?.hear(table.heard, time);
    for (const { pose, by } of table?.balls.values() ?? []) pose.name = this.options.names ? by : undefined;
    if (still) Object.assign(scene, { balls: [], flashes: [] });
    const balls = still ? [] : table?.balls.values() ?? [];
    this.view.draw(scene, (ctx, painter) => this.figures.faces.draw(ctx, painter, balls));
    const settling = this.tray?.show(now, still) ?? false;
    return settling || this.idle.moves || (table?.busy ?? false);
  }

  /** Not on a stream's own ground, whose other parts are placed around the lists. @param {number} now ms @param {boolean} still */
  #demo(now, still) {
    const { table, hello } = this.room;
    const listed = document.querySelector(".show-list > li") !== null;
    const idle = this.options.ground === null && table !== null && !table.busy && !listed;
    return this.idle.sceneAt(idle, now, table && hello && !still ? { table, hello } : null);
  }
}

/** Fills a list; its panel keeps its place while empty. @param {string} id @param {HTMLElement[]} rows */
function fill(id, rows) {
  byId(id).replaceChildren(...rows);
  byId(`${id}-panel`).dataset.empty = String(rows.length === 0);
}

/** Shows the QR code of the room. @param {string} room */
function showWay(room) {
  byId("join", HTMLImageElement).src = `api/v1/rooms/${encodeURIComponent(room)}/qr.svg`;
  byId("join-panel").hidden = false;
}

/** @param {Store} news @returns {Sound} at full volume */
function soundOf(news) {
  const context = new AudioContext({ latencyHint: "interactive" });
  void context.resume();
  const sound = new Sound(context, news);
  sound.on = true;
  sound.volume = 1;
  return sound;
}
