// The page as a live table: pointer, keys and news in, pictures and sentences out.

import { describeBoard } from "../board/alternative-text.js";
import { announceShape } from "../board/shape.js";
import { InstrumentPanel } from "../instruments/panel.js";
import { allowedAim } from "../model/board.js";
import { MAIN_ROOM, readBoardName } from "../model/presets.js";
import { oddsAt, oddsWords } from "../model/odds.js";
import { emptyScene } from "../model/scene.js";
import { getJson, messageOf } from "../net/api.js";
import { streamsFor } from "../net/streams.js";
import { ratioOf } from "../paint/geometry.js";
import { byId } from "../util/dom.js";
import { counted, signed } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { Credits } from "./account/credits.js";
import { Scoreboard } from "./account/scoreboard.js";
import { Controls } from "./input/controls.js";
import { FairPanel } from "./fairness/fair-panel.js";
import { Drawers } from "./input/drawers.js";
import { Dropper } from "./input/dropper.js";
import { switchGhost, switchSound } from "./input/switches.js";
import { LiveTable } from "./live.js";
import { Prover } from "./fairness/proof.js";
import { findTable } from "./rooms.js";
import { Show } from "./show/show.js";
import { Sound } from "./sound/sound.js";

/** @import { BoardView } from "../board/view.js" */
/** @import { Expected } from "../instruments/fit-meter.js" */
/** @import { Histogram } from "../instruments/histogram.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { Played, Session } from "../model/player/session.js" */
/** @import { Odds } from "../model/odds.js" */
/** @import { OddsReply } from "../net/replies.js" */
/** @import { Table } from "../model/table/table.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Wallet } from "./account/wallet.js" */
/** @import { Ghost } from "./show/ghost.js" */
/** @import { Ask, TableChoice } from "./input/controls.js" */
/** @import { LiveState } from "./live.js" */

/** @type {Partial<Record<LiveState, string>>} */
const STATE_TEXTS = {
  connecting: "Connecting…",
  live: "Live",
  asleep: "Ready",
  closed: "Closed",
};
const SCORE_MS = 200; // between two renewals of the list while balls rain

/** @typedef {{theme: Theme, view: BoardView, histogram: Histogram, ghost: Ghost,
 *   session: Session, wallet: Wallet, solver: Solver | null}} Parts */

/** The live page: one table at a time. */
export class TablePage {
  /** @type {number | null} the aim under the pointer, m */
  #hover = null;
  /** @type {string | null} as far as it is known */
  #mainBoard = null;
  #digest = "";
  /** @type {Odds[]} by aim, where they are known of the board */
  #odds = [];
  #shownCount = -1;
  /** @type {LiveState} */
  #state = "connecting";
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  #scoreStale = false;
  #scoreMs = 0;

  /** @param {Parts} parts @param {URLSearchParams} asked */
  constructor({ theme, view, histogram, ghost, session, wallet, solver }, asked) {
    this.theme = theme;
    this.view = view;
    this.histogram = histogram;
    this.ghost = ghost;
    this.session = session;
    this.credits = new Credits(session, wallet, {
      onFound: (played) => this.show.announcer.add(played),
      onChange: () => this.#scoreChanged(),
      say: (text) => this.#say(text),
    });
    this.means = { solver, wallet, streams: streamsFor(asked.get("stream"), solver !== null) };
    this.prover = new Prover(solver);
    this.sound = new Sound();
    this.show = new Show((text, score) => this.#say(text, score));
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.instruments = new InstrumentPanel(theme, {
      onExpected: (expected) => this.#compare(expected),
      onChange: () => this.loop.wake(),
      say: (text) => this.#say(text),
    });
    this.dropper = new Dropper({
      hasRoom: () => this.#hasRoom(),
      onDrop: (ask) => this.#drop(ask),
      onAuto: (running, left) => this.controls.showAuto(running, left),
    });
    this.controls = new Controls({
      onDrop: (count, ask) => this.#dropSome(count, ask),
      onAuto: (...asked) => this.dropper.start(...asked),
      onStop: () => this.dropper.stop(),
      onBoard: (choice) => this.#move(choice),
      onAim: () => this.#aimed(),
      onSeed: () => this.drawers.show("lab"),
    });
    this.scoreboard = new Scoreboard(session, theme, this.prover, (seed) => this.controls.setSeed(seed));
    this.drawers = new Drawers();
    switchSound(this.sound);
    switchGhost(this.ghost, () => this.loop.wake());
    this.#followPointer(view.moving);
    theme.onChange(() => this.#recolour());
    const { onLayout } = view;
    view.onLayout = (geometry) => {
      onLayout(geometry);
      this.loop.wake();
    };
    document.addEventListener("visibilitychange", () => this.loop.wake());
    this.fairPanel = new FairPanel({
      onCheck: () => this.live.fair.end(),
      isBusy: () => this.live.own.count > 0,
    });
    this.live = this.#join(asked.get("room") || MAIN_ROOM);
    this.credits.recovery.seekAllBut(this.live.room);
    const seed = asked.get("seed");
    if (seed !== null) this.controls.setSeed(seed);
  }

  /** @param {string} room */
  #join(room) {
    this.dropper.clear();
    document.documentElement.dataset.state = "connecting";
    this.session.enter(room);
    return new LiveTable(room, {
      onTable: (hello, table) => this.#setTable(hello, table),
      onState: (state, detail) => this.#showState(state, detail),
      onPlayed: (played) => this.#played(played),
      onHit: (bin) => this.#hit(bin),
      onError: (message, code) => this.#refused(message, code),
      onChange: () => this.loop.wake(),
      onSession: () => { this.fairPanel.show(this.live.fair); this.credits.show(); },
      onEnded: (ended, heard) => this.fairPanel.check(ended, heard),
      onBehind: (stay) => this.credits.recovery.seek([stay]),
      onPong: (ms) => this.instruments.line.pong(ms),
      onSnapshot: () => this.instruments.ball.measure(),
    }, this.means);
  }

  /** @param {TableChoice} choice */
  async #move(choice) {
    try {
      const room = await findTable(choice, this.#mainBoard, this.session);
      if (room === this.live.room) return;
      const query = room === MAIN_ROOM
        ? window.location.pathname
        : `?room=${encodeURIComponent(room)}`;
      window.history.replaceState(null, "", query);
      this.live.close();
      this.live = this.#join(room);
      this.credits.recovery.seekAllBut(room);
    } catch (error) {
      this.#say(`That table cannot be opened: ${messageOf(error)}`);
      this.#showTable();
    }
  }

  #showTable() {
    const { hello } = this.live;
    if (!hello) return;
    this.controls.showChoice(hello.board_name);
    this.controls.showKnocking(hello.mode === "interacting");
  }

  /** @param {Hello} hello @param {Table} table */
  #setTable(hello, table) {
    const { board, board_name: name, slots } = hello;
    if (hello.room === MAIN_ROOM) this.#mainBoard = name;
    this.prover.know(hello.board_digest, board);
    // A line that came back finds the same board; the fields keep what was typed in them.
    if (this.#digest !== hello.board_digest) {
      this.#digest = hello.board_digest;
      announceShape(ratioOf(board));
      this.#learnOdds(hello);
      this.controls.setBoard(name, board, slots);
      this.ghost.setBoard(board);
      this.sound.setBoard(board);
      this.view.setBoard(board, slots);
      this.view.moving.setAttribute("aria-label", describeBoard(board));
    }
    this.controls.showKnocking(hello.mode === "interacting");
    this.show.setTable(table);
    table.onPassed = this.ghost.follow;
    table.tracing = this.#still.matches;
    this.instruments.setTable(hello, table);
    this.histogram.setBoard(board, hello.stats.histogram, this.instruments.fit.expected);
    this.#showCount();
    this.loop.wake();
  }

  /** @param {Hello} hello */
  async #learnOdds({ board_digest: digest, board_name: name, mode }) {
    this.#odds = [];
    try {
      // Where balls knock each other no odds of one ball hold; other boards were never counted.
      if (mode !== "interacting" && readBoardName(name)) {
        const found = /** @type {OddsReply} */ (await getJson(`boards/${name}/odds`));
        if (digest === this.#digest && digest === found.board_digest) this.#odds = found.aims;
      }
    } catch (error) {
      this.#say(`The odds of this table are unknown: ${messageOf(error)}`);
    }
    if (digest === this.#digest) this.#showOdds();
  }

  #aimed() {
    if (this.#odds.length) this.#showOdds();
    this.loop.wake();
  }

  #showOdds() {
    const middle = this.live.hello?.board.drop.x ?? 0;
    const odds = oddsAt(this.#odds, this.controls.start.aim, middle);
    byId("odds-note").textContent = odds ? oddsWords(odds) : "";
    this.instruments.fit.setRecord(odds, this.instruments.open);
  }

  #hasRoom() {
    const { live } = this;
    const flying = (live.table?.balls.size ?? 0) + live.own.unanswered;
    return flying < (live.hello?.limits.balls ?? Number.POSITIVE_INFINITY);
  }

  /**
   * One ball goes at once, whatever the table has to say to it; more go one by one.
   * @param {number} count
   * @param {() => Ask} ask
   */
  #dropSome(count, ask) {
    if (count === 1) {
      this.#drop(ask());
      return;
    }
    this.show.announcer.expect(count, this.live.own.count === 0);
    this.dropper.shower(count, ask);
  }

  /** @param {Ask} ask */
  #drop(ask) {
    if (!this.credits.allow(ask, this.live)) return false;
    const sent = this.live.drop(ask);
    this.show.dropped();
    if (!sent) this.#say("There is no line to the table yet. Nothing was dropped.");
    return sent;
  }

  /** @param {number} now */
  #draw(now) {
    const { live, view, instruments } = this;
    const { table } = live;
    const t = live.time(now);
    const quiet = this.#still.matches;
    live.settle(quiet ? Number.POSITIVE_INFINITY : t, now);
    const scene = table ? table.sceneAt(t, now / 1000) : emptyScene();
    if (table?.growsWhenDrawn) instruments.ball.measure();
    if (table) this.sound.hear(table.heard, t);
    const encore = this.show.show(scene, now / 1000, quiet);
    if (quiet) Object.assign(scene, { balls: [], flashes: [], paths: live.ownPaths() });
    scene.aim = this.#hover ?? this.controls.start.aim;
    scene.chosen = instruments.open ? instruments.ball.chosen : null;
    view.draw(scene);
    this.ghost.paint(now);
    this.histogram.refresh(now);
    if (this.#shownCount !== this.histogram.total) this.#showCount();
    if (this.#scoreStale && now - this.#scoreMs >= SCORE_MS) this.#showScore(now);
    const measuring = instruments.show(live, this.histogram.counts, this.session.scores, now);
    return (table?.busy ?? false) || this.ghost.pending || this.histogram.pending
      || this.#scoreStale || measuring || encore;
  }

  /** @param {Played} played */
  #played(played) {
    this.credits.settle(played);
    this.#scoreChanged();
    this.fairPanel.show(this.live.fair);
    const { bin, score } = played;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin !== null) this.sound.chime(score, (bin + 0.5) / this.histogram.counts.length);
    const looked = document.visibilityState !== "hidden";
    this.show.played(played, { last: looked && this.live.own.count === 0, still: this.#still.matches });
    const won = this.dropper.landed(played);
    if (won !== null) this.#say(`Auto-drop has stopped: ${signed(won)}.`);
  }

  #scoreChanged() {
    this.#scoreStale = true;
    // A hidden tab draws no pictures; its list is renewed all the same.
    if (document.visibilityState === "hidden") this.#showScore(performance.now());
    else this.loop.wake();
  }

  /** @param {number} now */
  #showScore(now) {
    this.#scoreStale = false;
    this.#scoreMs = now;
    this.scoreboard.show();
    this.credits.show();
  }

  /** @param {number} bin */
  #hit(bin) {
    this.histogram.add(bin);
    this.loop.wake();
  }

  /** @param {Expected | null} expected */
  #compare(expected) {
    this.histogram.setExpected(expected);
    this.#showCount();
    this.loop.wake();
  }

  #showCount() {
    const { total } = this.histogram;
    const { expected } = this.instruments.fit;
    this.#shownCount = total;
    byId("tray-count").textContent = total
      ? `${counted(total, "drop")} landed at this table`
      : "Nothing has landed here yet";
    byId("tray-key").hidden = !expected;
    byId("tray-key").textContent = expected ? `expected: ${expected.label}` : "";
  }

  /** @param {string} message @param {string} [code] */
  #refused(message, code) {
    // A full table is no fault of a shower of balls: it goes on as soon as there is room.
    if (code === "too-many-balls" && this.dropper.running) return;
    if (code === "room-halted") this.dropper.clear();
    this.#say(message);
  }

  /** @param {LiveState} state @param {string} [detail] */
  #showState(state, detail) {
    document.documentElement.dataset.state = state;
    byId("state-text").textContent = state === "reconnecting"
      ? `Reconnecting… in ${detail}`
      : (STATE_TEXTS[state] ?? "");
    if (state === "closed") this.#say(detail || "The table is closed.");
    if (state === "reconnecting" && this.#state !== state) this.#say("The line to the table broke.");
    if (state === "reconnecting" || state === "closed") this.dropper.clear();
    if (this.#state === "reconnecting" && state !== this.#state) this.#say("Back at the table.");
    this.#state = state;
    if (state === "live") this.instruments.line.wake();
    else this.instruments.line.rest(this.live);
    this.loop.wake();
  }

  /** @param {string} text @param {number} [score] */
  #say(text, score) {
    const result = byId("result");
    result.textContent = text;
    result.style.setProperty(
      "--paid", score === undefined ? "transparent" : this.theme.payout(score).fill,
    );
  }

  #recolour() {
    this.view.repaint();
    this.ghost.recolour();
    this.histogram.draw();
    this.scoreboard.recolour();
    this.loop.wake();
  }

  /** @param {HTMLCanvasElement} canvas */
  #followPointer(canvas) {
    /** @param {MouseEvent} event @returns {number | null} metres */
    const aim = (event) => {
      const place = this.view.aimOf(event);
      const { hello } = this.live;
      return place?.above && hello ? allowedAim(hello.board, hello.slots, place.x) : null;
    };
    /** @param {number | null} x metres */
    const hover = (x) => {
      if (x === this.#hover) return;
      this.#hover = x;
      canvas.style.cursor = x === null ? "" : "pointer";
      this.loop.wake();
    };
    canvas.addEventListener("pointermove", (event) => {
      hover(event.pointerType === "mouse" ? aim(event) : null);
    });
    canvas.addEventListener("pointerleave", () => hover(null));
    canvas.addEventListener("click", (event) => {
      const x = aim(event);
      const place = this.view.aimOf(event);
      if (x !== null) this.controls.drop(x);
      else if (place && this.live.table) this.instruments.pick(place.x, place.y);
    });
  }
}
