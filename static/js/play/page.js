// The page as a live table: pointer, keys and news in, pictures and sentences out.

import { describeBoard } from "../board/alternative-text.js";
import { announceShape } from "../board/shape.js";
import { InstrumentPanel } from "../instruments/panel.js";
import { allowedAim } from "../model/board.js";
import { MAIN_ROOM } from "../model/presets.js";
import { PACES } from "../model/table/pace.js";
import { emptyScene } from "../model/scene.js";
import { messageOf } from "../net/api.js";
import { streamsFor } from "../net/streams.js";
import { ratioOf } from "../paint/geometry.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { signed } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { CompanyPanel } from "./account/company-panel.js";
import { Credits } from "./account/credits.js";
import { Scoreboard } from "./account/scoreboard.js";
import { Self } from "./account/self.js";
import { BoardPointer } from "./input/board-pointer.js";
import { Controls } from "./input/controls.js";
import { FairPanel } from "./fairness/fair-panel.js";
import { Drawers } from "./input/drawers.js";
import { Dropper } from "./input/dropper.js";
import { switchScheme } from "./input/settings.js";
import { switchGhost, switchPile } from "./input/switches.js";
import { haltedWords } from "./halted.js";
import { LiveTable } from "./live.js";
import { Prover } from "./fairness/proof.js";
import { findTable, putIntoAddress, roomOfAddress } from "./rooms.js";
import { Demo } from "./show/demo.js";
import { OddsNote } from "./show/odds-note.js";
import { Show } from "./show/show.js";
import { SoundChoice } from "./sound/choice.js";
import { Sound } from "./sound/sound.js";

/** @import { BoardView } from "../board/view.js" */
/** @import { Expected } from "../instruments/fit-meter.js" */
/** @import { Histogram } from "../instruments/histogram.js" */
/** @import { Entry } from "../instruments/pile/columns.js" */
/** @import { Hello } from "../model/messages.js" */
/** @import { Played, Session } from "../model/player/session.js" */
/** @import { Table } from "../model/table/table.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Wallet } from "./account/wallet.js" */
/** @import { Ghost } from "./show/ghost.js" */
/** @import { Ask, TableChoice } from "./input/controls.js" */
/** @import { LiveState } from "./live.js" */

/** @type {Partial<Record<LiveState, string>>} */
const STATE_TEXTS = {
  connecting: t("play.connecting"),
  live: t("play.live"),
  asleep: t("play.ready"),
  closed: t("play.closed"),
};
const SCORE_MS = 200; // between two renewals of the list, and of the count, while balls rain

/** @typedef {{theme: Theme, view: BoardView, histogram: Histogram, ghost: Ghost,
 *   session: Session, wallet: Wallet, solver: Solver | null}} Parts */

/** The live page: one table at a time. */
export class TablePage {
  /** @type {string | null} as far as it is known */
  #mainBoard = null;
  #digest = "";
  #shownCount = -1;
  /** @type {number | null} */
  #shownShare = null;
  /** @type {LiveState} */
  #state = "connecting";
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  #scoreStale = false;
  #scoreMs = 0;
  #countMs = 0;

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
    const self = new Self(window.localStorage);
    this.company = new CompanyPanel(theme, self, () => this.live.appear());
    this.means = { solver, wallet, self, streams: streamsFor(asked.get("stream"), solver !== null) };
    this.prover = new Prover(solver);
    this.sound = new Sound();
    this.show = new Show(view, (text, score) => this.#say(text, score));
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.demo = new Demo(window.localStorage, () => this.loop.wake());
    this.instruments = new InstrumentPanel(theme, {
      onExpected: (expected) => this.#compare(expected),
      onChange: () => this.loop.wake(),
      say: (text) => this.#say(text),
    });
    this.odds = new OddsNote({
      onOdds: (odds) => this.instruments.fit.setRecord(odds, this.instruments.open),
      aim: () => this.controls.start.aim,
      say: (text) => this.#say(text),
    });
    this.dropper = new Dropper({
      hasRoom: () => this.#hasRoom(),
      onDrop: (ask) => this.#drop(ask),
      onAuto: (running, left) => this.controls.showAuto(running, left),
    });
    this.controls = new Controls(theme, {
      onDrop: (count, ask) => this.#dropSome(count, ask),
      onAuto: (...asked) => this.dropper.start(...asked),
      onStop: () => this.dropper.stop(),
      onBoard: (choice) => this.#move(choice),
      onAim: () => this.#aimed(),
      onPace: () => this.#setPace(),
      onSeed: () => this.drawers.show("lab"),
    });
    this.scoreboard = new Scoreboard(session, theme, this.prover, (seed) => this.controls.setSeed(seed));
    this.drawers = new Drawers();
    this.soundChoice = new SoundChoice(this.sound, window.localStorage);
    switchScheme(theme);
    switchGhost(this.ghost, () => this.loop.wake());
    switchPile(histogram, theme, { onChange: () => this.loop.wake(), say: (text) => this.#say(text) });
    this.pointer = new BoardPointer(view, {
      aimAt: (x) => (this.live.hello ? allowedAim(this.live.hello.board, this.live.hello.slots, x) : null),
      onDrop: (x) => this.controls.drop(x),
      onPick: (x, y) => { if (this.live.table) this.instruments.pick(x, y); },
      onHover: () => this.loop.wake(),
    });
    theme.onChange(() => this.#recolour());
    const { onLayout } = view;
    view.onLayout = (geometry) => {
      onLayout(geometry);
      this.loop.wake();
    };
    document.addEventListener("visibilitychange", () => this.loop.wake());
    window.addEventListener("popstate", () => this.#change(roomOfAddress()));
    this.fairPanel = new FairPanel({
      onCheck: () => this.live.fair.end(),
      isBusy: () => this.live.own.count > 0,
    });
    this.live = this.#join(roomOfAddress());
    this.credits.recovery.seekAllBut(this.live.room);
    if (asked.has("seed")) this.controls.setSeed(asked.get("seed") ?? "");
  }

  /** @param {string} room */
  #join(room) {
    this.dropper.clear();
    document.documentElement.dataset.state = "connecting";
    this.session.enter(room);
    return new LiveTable(room, {
      onTable: (hello, table) => this.#setTable(hello, table),
      onState: (state, detail) => this.#showState(state, detail),
      onSeen: (played) => this.#seen(played),
      onPlayed: (played) => this.#played(played),
      onHit: (bin, entry) => this.#hit(bin, entry),
      onError: (message, code) => this.#refused(message, code),
      onChange: () => this.loop.wake(),
      onHalted: (halted) => { this.show.hush(halted); this.#say(haltedWords(halted)); },
      onCompany: () => this.company.renew(this.live),
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
      putIntoAddress(room);
      this.#change(room);
    } catch (error) {
      this.#say(t("play.table-fails", { why: messageOf(error) }));
      this.#showTable();
    }
  }

  /** @param {string} room */
  #change(room) {
    if (room === this.live.room) return; // the address changed in its fragment alone
    this.live.close();
    this.live = this.#join(room);
    this.credits.recovery.seekAllBut(room);
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
      this.odds.learn(hello);
      this.controls.setBoard(name, board, slots);
      this.ghost.setBoard(board);
      this.sound.setBoard(board);
      this.view.setBoard(board, slots);
      this.view.moving.setAttribute("aria-label", describeBoard(board));
    }
    this.controls.showKnocking(hello.mode === "interacting");
    this.show.setTable(table);
    this.#setPace();
    table.onPassed = this.ghost.follow;
    table.tracing = this.#still.matches;
    this.demo.setTable(hello, table);
    this.instruments.setTable(hello, table);
    this.histogram.setBoard(board, hello.stats.histogram, this.instruments.fit.expected);
    this.#showCount();
    this.loop.wake();
  }

  #setPace() {
    const { table } = this.live;
    if (!table) return;
    table.pace = table.solve ? this.controls.pace : PACES.real;
    this.controls.showPace(table.solve !== null);
  }

  #aimed() {
    this.odds.aimed();
    this.loop.wake();
  }

  #hasRoom() {
    const { table, own, hello } = this.live;
    return (table?.balls.size ?? 0) + own.unanswered < (hello?.limits.balls ?? Number.POSITIVE_INFINITY);
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
    if (sent) this.soundChoice.offer();
    else this.#say(t("play.no-line"));
    return sent;
  }

  /** @param {number} now */
  #draw(now) {
    const { live, view, instruments } = this;
    const { table } = live;
    const t = live.time(now);
    const quiet = this.#still.matches;
    live.settle(quiet ? Number.POSITIVE_INFINITY : t, now);
    const demo = this.demo.sceneAt(now, table, quiet);
    const scene = demo ?? table?.sceneAt(t, now / 1000) ?? emptyScene();
    if (table?.growsWhenDrawn) instruments.ball.measure();
    if (table) this.sound.hear(table.heard, t);
    const encore = this.show.show(scene, now / 1000, quiet);
    if (quiet) Object.assign(scene, { balls: [], flashes: [], paths: live.ownPaths() });
    scene.aim = this.pointer.hover ?? this.controls.start.aim;
    scene.chosen = instruments.open ? instruments.ball.chosen : null;
    view.draw(scene);
    this.ghost.paint(now);
    this.histogram.refresh(now, quiet);
    const counting = this.#shownCount !== this.histogram.total || this.#shownShare !== this.histogram.share;
    if (counting && now - this.#countMs >= SCORE_MS) this.#showCount(now);
    if (this.#scoreStale && now - this.#scoreMs >= SCORE_MS) this.#showScore(now);
    const measuring = instruments.show(live, this.histogram.counts, this.session.scores, now);
    return (table?.busy ?? false) || this.ghost.pending || this.histogram.pending
      || this.#scoreStale || counting || measuring || encore || demo !== null;
  }

  /** @param {Played} played the table has told it: it counts */
  #played(played) {
    this.credits.settle(played);
    this.#scoreChanged();
    this.fairPanel.show(this.live.fair);
  }

  /** @param {Played} played it is seen to land */
  #seen(played) {
    const { bin, score } = played;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin !== null) this.sound.chime(score, (bin + 0.5) / this.histogram.counts.length);
    const looked = document.visibilityState !== "hidden";
    const last = looked && this.live.own.unseen === 0 && !this.dropper.running;
    this.show.played(played, { last, still: this.#still.matches, atOnce: this.controls.pace === PACES.instant });
    const won = this.dropper.landed(played);
    if (won !== null) this.#say(t("play.auto-stopped", { won: signed(won) }));
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

  /** @param {number} bin @param {Entry} entry */
  #hit(bin, entry) {
    this.histogram.add(bin, entry);
    this.loop.wake();
  }

  /** @param {Expected | null} expected */
  #compare(expected) {
    this.histogram.setExpected(expected);
    this.#showCount();
    this.loop.wake();
  }

  /** @param {number} [now] */
  #showCount(now = performance.now()) {
    const { total, share } = this.histogram;
    const { expected } = this.instruments.fit;
    [this.#shownCount, this.#shownShare, this.#countMs] = [total, share, now];
    const words = share !== null && share > 1 ? "play.landed-as-discs" : "play.landed-here";
    byId("tray-count").textContent = total ? t(words, { n: total, share: share ?? 1 }) : t("play.none-landed");
    byId("tray-key").hidden = !expected || share !== null;
    byId("tray-key").textContent = expected ? t("play.expected", { label: expected.label }) : "";
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
      ? t("play.reconnecting", { seconds: detail ?? "" })
      : (STATE_TEXTS[state] ?? "");
    if (state === "closed") this.#say(detail || t("play.table-closed"));
    if (state === "reconnecting" && this.#state !== state) this.#say(t("play.line-broke"));
    if (state === "reconnecting" || state === "closed") this.dropper.clear();
    if (this.#state === "reconnecting" && state !== this.#state) this.#say(t("play.back"));
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
}
