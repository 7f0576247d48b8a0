// The page as a live table: pointer, keys and news in, pictures and words out.

import { Announcer } from "./announcer.js";
import { MAIN_ROOM } from "../model/presets.js";
import { emptyScene } from "../board/view.js";
import { Controls } from "./input/controls.js";
import { byId } from "../util/dom.js";
import { Dropper } from "./input/dropper.js";
import { counted } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { allowedStart, announceShape } from "../paint/geometry.js";
import { LiveTable } from "./live.js";
import { Measures } from "../instruments/panel.js";
import { Scoreboard } from "./scoreboard.js";
import { Sound } from "./sound.js";
import { switchGhost, switchSound } from "./input/switches.js";
import { findTable } from "./rooms.js";
import { describeBoard } from "../board/alternative-text.js";

const STATE_WORDS = {
  connecting: "Connecting…",
  live: "Live",
  asleep: "Ready",
  closed: "Closed",
};
const SCORE_MS = 200; // between two renewals of the list while balls rain

/** @param {import("./main.js").Parts} parts @param {URLSearchParams} asked */
export function startTable(parts, asked) {
  const page = new TablePage(parts, asked.get("room") || MAIN_ROOM, asked.get("stream"));
  if (asked.has("seed")) page.controls.setSeed(asked.get("seed"));
  return page;
}

class TablePage {
  #hover = null;
  #mainBoard = null;
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  #scoreStale = false;
  #scoreMs = 0;

  constructor({ theme, view, histogram, ghost, session }, room, stream) {
    Object.assign(this, { theme, view, histogram, ghost, session, stream: stream ?? undefined });
    this.sound = new Sound();
    this.announcer = new Announcer((text, score) => this.#say(text, score));
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.measures = new Measures(theme, {
      onExpected: (expected) => this.#compare(expected),
      onChange: () => this.loop.wake(),
      say: (text) => this.#say(text),
    });
    this.dropper = new Dropper({
      room: () => this.#hasRoom(),
      onDrop: (ask) => this.#drop(ask),
      onAuto: (running, left) => this.controls.showAuto(running, left),
    });
    this.controls = new Controls({
      onDrop: (count, ask) => this.#dropSome(count, ask),
      onAuto: (rate, count, ask) => this.dropper.start(rate, count, ask),
      onStop: () => this.dropper.stop(),
      onBoard: (choice) => this.#move(choice),
      onAim: () => this.loop.wake(),
    });
    this.scoreboard = new Scoreboard(session, theme, (seed) => this.controls.setSeed(seed));
    switchSound(this.sound);
    switchGhost(this.ghost, () => this.loop.wake());
    this.#followPointer(byId("board-moving"));
    theme.onChange(() => this.#recolour());
    const { onLayout } = view;
    view.onLayout = (geometry) => {
      onLayout(geometry);
      this.loop.wake();
    };
    document.addEventListener("visibilitychange", () => this.loop.wake());
    this.#join(room);
  }

  #join(room) {
    this.live?.close();
    this.dropper.clear();
    document.documentElement.dataset.state = "connecting";
    this.live = new LiveTable(room, {
      onTable: (hello, counts) => this.#setTable(hello, counts),
      onState: (state, detail) => this.#showState(state, detail),
      onPlayed: (played) => this.#played(played),
      onHit: (bin) => this.#hit(bin),
      onError: (message, code) => this.#refused(message, code),
      onChange: () => this.loop.wake(),
      onPong: (ms) => this.measures.line.pong(ms),
      onSnapshot: () => this.measures.ball.measure(),
    }, this.stream);
    this.session.enter(room);
  }

  async #move(choice) {
    try {
      const room = await findTable(choice, this.#mainBoard, this.session);
      if (room === this.live.room) return;
      const query = room === MAIN_ROOM
        ? window.location.pathname
        : `?room=${encodeURIComponent(room)}`;
      window.history.replaceState(null, "", query);
      this.#join(room);
    } catch (error) {
      this.#say(`That table cannot be opened: ${error.message}`);
      if (this.live.hello) this.#showTable();
    }
  }

  #showTable() {
    this.controls.showChoice(this.live.hello.board_name);
    this.controls.showKnocking(this.live.hello.mode === "interacting");
  }

  #setTable(hello, counts) {
    const { board, board_name: name, slots } = hello;
    if (hello.room === MAIN_ROOM) this.#mainBoard = name;
    // A line that came back finds the same board; the fields keep what was typed in them.
    if (this.digest !== hello.board_digest) {
      this.digest = hello.board_digest;
      announceShape(board);
      this.controls.setBoard(name, board, slots);
      this.ghost.setBoard(board);
      this.sound.setBoard(board);
      this.view.setBoard(board, slots);
      byId("board-moving").setAttribute("aria-label", describeBoard(board));
    }
    this.controls.showKnocking(hello.mode === "interacting");
    this.live.table.onPassed = this.ghost.follow;
    this.live.table.tracing = this.#still.matches;
    this.measures.setTable(hello, this.live.table);
    this.histogram.setBoard(board, counts, this.measures.fit.expected);
    this.#showCount();
    this.loop.wake();
  }

  #hasRoom() {
    const { live } = this;
    const flying = (live.table?.balls.size ?? 0) + live.unanswered;
    return flying < (live.hello?.limits?.balls ?? Number.POSITIVE_INFINITY);
  }

  /** One ball goes at once, whatever the table has to say to it; more go one by one. */
  #dropSome(count, ask) {
    if (count === 1) this.#drop(ask());
    else this.dropper.shower(count, ask);
  }

  #drop(ask) {
    const sent = this.live.drop(ask);
    if (!sent) this.#say("There is no line to the table yet. Nothing was dropped.");
    return sent;
  }

  #draw(now) {
    const { live, view, measures } = this;
    const { table } = live;
    const t = live.time(now);
    const quiet = this.#still.matches;
    live.settle(quiet ? Number.POSITIVE_INFINITY : t, now);
    const scene = table ? table.sceneAt(t, now / 1000) : emptyScene();
    if (table?.obstacles) measures.ball.measure();
    if (table) this.sound.hear(table.heard, t);
    if (quiet) scene.balls.length = 0;
    if (quiet) scene.flashes = [];
    if (quiet) scene.paths = live.ownPaths();
    scene.aim = this.#hover ?? this.controls.start.x;
    scene.chosen = measures.open ? measures.ball.chosen : null;
    view.draw(scene);
    this.ghost.paint(now);
    this.histogram.refresh(now);
    if (this.shownCount !== this.histogram.total) this.#showCount();
    if (this.#scoreStale && now - this.#scoreMs >= SCORE_MS) this.#showScore(now);
    const measuring = measures.show(live, this.histogram.counts, this.session.scores, now);
    return (table?.busy ?? false) || this.ghost.pending || this.histogram.pending
      || this.#scoreStale || measuring;
  }

  #played(played) {
    this.session.settle(played);
    this.#scoreStale = true;
    // A hidden tab draws no pictures; its list is renewed all the same.
    if (document.visibilityState === "hidden") this.#showScore(performance.now());
    else this.loop.wake();
    const { bin, score } = played;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin !== null) this.sound.chime(score, (bin + 0.5) / this.histogram.counts.length);
    this.announcer.add(played);
  }

  #showScore(now) {
    this.#scoreStale = false;
    this.#scoreMs = now;
    this.scoreboard.show();
  }

  #hit(bin) {
    this.histogram.add(bin);
    this.loop.wake();
  }

  #compare(expected) {
    this.histogram.setExpected(expected);
    this.#showCount();
    this.loop.wake();
  }

  #showCount() {
    const { total } = this.histogram;
    const { expected } = this.measures.fit;
    this.shownCount = total;
    byId("tray-count").textContent = total
      ? `${counted(total, "drop")} landed at this table`
      : "Nothing has landed here yet";
    byId("tray-key").hidden = !expected;
    byId("tray-key").textContent = expected ? `expected: ${expected.label}` : "";
  }

  #refused(message, code) {
    // A full table is no fault of a shower of balls: it goes on as soon as there is room.
    if (code === "too-many-balls" && this.dropper.running) return;
    this.#say(message);
  }

  #showState(state, detail) {
    document.documentElement.dataset.state = state;
    byId("state-text").textContent = state === "reconnecting"
      ? `Line lost, trying again in ${detail}`
      : STATE_WORDS[state];
    if (state === "closed") this.#say(detail || "The table is closed.");
    if (state === "reconnecting" && this.state !== state) this.#say("The line to the table broke.");
    if (state === "reconnecting" || state === "closed") this.dropper.clear();
    if (this.state === "reconnecting" && state !== this.state) this.#say("Back at the table.");
    this.state = state;
    if (state === "live") this.measures.line.wake();
    else this.measures.line.rest(this.live);
    this.loop.wake();
  }

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
    this.scoreboard.show();
    this.loop.wake();
  }

  #followPointer(canvas) {
    const aim = (event) => {
      const place = this.view.aimOf(event);
      if (!place?.above || !this.live.hello) return null;
      return allowedStart(this.live.hello.board, this.live.hello.slots, place.x);
    };
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
      else if (place && this.live.table) this.measures.pick(place.x, place.y);
    });
  }
}
