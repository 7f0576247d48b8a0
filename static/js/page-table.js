// The page as a live table: pointer, keys and news in, pictures and words out.

import { boardName, MAIN_ROOM, roomOf } from "./boards.js";
import { Controls } from "./controls.js";
import { byId } from "./dom.js";
import { expectedOf } from "./expected.js";
import { counted, multiplier } from "./format.js";
import { FrameLoop } from "./frame-loop.js";
import { allowedStart, announceShape } from "./geometry.js";
import { LiveTable } from "./live.js";
import { Scoreboard } from "./scoreboard.js";
import { describeBoard } from "./words.js";
import { emptyScene } from "./board-view.js";

const STATE_WORDS = {
  connecting: "Connecting…",
  live: "Live",
  asleep: "Ready",
  closed: "Closed",
};

/** @param {import("./main.js").Parts} parts @param {URLSearchParams} asked */
export function startTable(parts, asked) {
  const page = new TablePage(parts, asked.get("room") || MAIN_ROOM);
  if (asked.has("seed")) page.controls.setSeed(asked.get("seed"));
  return page;
}

class TablePage {
  #hover = null;
  #mainBoard = null;
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");

  constructor({ theme, view, histogram, ghost, session }, room) {
    Object.assign(this, { theme, view, histogram, ghost, session });
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.controls = new Controls({
      onDrop: (ask) => this.#drop(ask),
      onBoard: (choice) => this.#move(boardName(choice)),
      onAim: () => this.loop.wake(),
    });
    this.scoreboard = new Scoreboard(session, theme, (seed) => this.controls.setSeed(seed));
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
    document.documentElement.dataset.state = "connecting";
    this.live = new LiveTable(room, {
      onTable: (hello, counts) => this.#setTable(hello, counts),
      onState: (state, detail) => this.#showState(state, detail),
      onPlayed: (played) => this.#played(played),
      onHit: (bin) => this.#hit(bin),
      onError: (message) => this.#say(message),
      onChange: () => this.loop.wake(),
    });
    this.session.enter(room);
  }

  #move(name) {
    const room = roomOf(name, this.#mainBoard);
    if (room === this.live.room) return;
    const query = room === MAIN_ROOM ? window.location.pathname : `?room=${encodeURIComponent(room)}`;
    window.history.replaceState(null, "", query);
    this.#join(room);
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
      this.view.setBoard(board, slots);
      byId("board-moving").setAttribute("aria-label", describeBoard(board));
    }
    this.live.table.onPassed = this.ghost.follow;
    this.live.table.tracing = this.#still.matches;
    this.expected = expectedOf(name, board.bins.multipliers.length);
    this.histogram.setBoard(board, counts, this.expected);
    this.#showCount();
    this.loop.wake();
  }

  #drop(ask) {
    if (!this.live.drop(ask)) this.#say("There is no line to the table yet. Nothing was dropped.");
  }

  #draw(now) {
    const { live, view } = this;
    const t = live.time(now);
    const quiet = this.#still.matches;
    live.settle(quiet ? Number.POSITIVE_INFINITY : t, now);
    const scene = live.table ? live.table.sceneAt(t, now / 1000) : emptyScene();
    if (quiet) scene.balls.length = 0;
    if (quiet) scene.flashes = [];
    if (quiet) scene.paths = live.ownPaths();
    scene.aim = this.#hover ?? this.controls.start.x;
    view.draw(scene);
    this.ghost.paint(now);
    this.histogram.refresh(now);
    if (this.shownCount !== this.histogram.total) this.#showCount();
    return (live.table?.busy ?? false) || this.ghost.pending || this.histogram.pending;
  }

  #played(played) {
    this.session.settle(played);
    this.scoreboard.show();
    const { bin, score, seed } = played;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    if (bin === null) this.#say(`Seed ${seed} came to rest in no bin. Its stake is back.`);
    else this.#say(`Bin ${bin} pays ${multiplier(score)} for seed ${seed}.`, score);
  }

  #hit(bin) {
    this.histogram.add(bin);
    this.loop.wake();
  }

  #showCount() {
    const { total } = this.histogram;
    this.shownCount = total;
    byId("tray-count").textContent = total
      ? `${counted(total, "drop")} landed at this table`
      : "Nothing has landed here yet";
    byId("tray-key").hidden = !this.expected;
    byId("tray-key").textContent = this.expected ? `expected: ${this.expected.label}` : "";
  }

  #showState(state, detail) {
    document.documentElement.dataset.state = state;
    byId("state-text").textContent = state === "reconnecting"
      ? `Line lost, trying again in ${detail}`
      : STATE_WORDS[state];
    if (state === "closed") this.#say(detail || "The table is closed.");
    if (state === "reconnecting" && this.state !== state) this.#say("The line to the table broke.");
    if (this.state === "reconnecting" && state !== this.state) this.#say("Back at the table.");
    this.state = state;
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
      if (x !== null) this.controls.drop(x);
    });
  }
}
