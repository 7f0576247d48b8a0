// The ball of the day: a tap on a bin is the guess, then the ball falls. The browser keeps the streak.

import { openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { replayLink } from "../net/drop-address.js";
import { binBox } from "../paint/board.js";
import { paintPath } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { dropOf, Replay } from "../replay/replay.js";
import { language, t } from "../texts/text.js";
import { byId, make, onClick } from "../util/dom.js";
import { plain } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { local } from "../util/storage.js";
import { readStored } from "../util/stored.js";
import { ballOfDay, isBook, marksOf, streakAt, untilNext, withGuess } from "./streak.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Book } from "./streak.js" */

const KEY = "plinko.today.1";
const ABOVE = 0.6; // of a bin's height: its button begins that far above it

class TodayPage {
  /** When the ball began to fall, ms; null before, and if it has landed. @type {number | null} */
  #since = null;
  /** The time shown, s. */
  #time = 0;

  /** @param {Theme} theme @param {Replay} replay */
  constructor(theme, replay) {
    this.theme = theme;
    this.replay = replay;
    this.nowMs = Date.now();
    this.book = readStored(local, KEY, isBook);
    const { board } = replay;
    this.picks = board.bins.multipliers.map((score, bin) => {
      const name = t("replay.guess-bin", { bin, pays: prizeOf(board, bin, score) });
      const pick = make("button", { class: "pick", type: "button", "aria-pressed": "false", "aria-label": name });
      pick.addEventListener("click", () => this.#guess(bin));
      return pick;
    });
    byId("picks").append(...this.picks);
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.stage = new Stage(theme, () => this.#layOut());
    this.stage.setBoard(board);
    byId("date").textContent = new Date(this.nowMs).toLocaleDateString(language, { dateStyle: "long", timeZone: "UTC" });
    byId("result").textContent = t("today.ask");
    byId("replay", HTMLAnchorElement).href = replayLink(ballOfDay(this.nowMs));
    onClick("share", () => this.#share());
    this.#showTally();
    if (this.book?.day === ballOfDay(this.nowMs).seed) this.#skip(this.book);
  }

  #layOut() {
    const { geometry } = this.stage;
    if (!geometry) return;
    this.picks.forEach((pick, bin) => {
      const { x, y, width, height } = binBox(geometry, this.replay.board, bin);
      const more = ABOVE * height;
      Object.assign(pick.style, {
        left: `${x - 1}px`, top: `${y - more}px`, width: `${width + 2}px`, height: `${height + more}px`,
      });
    });
    this.loop.wake();
    showState("replay", t("play.ready")); // its bins can be tapped from now on
  }

  /** The day's only guess. @param {number} bin */
  #guess(bin) {
    this.picks.forEach((pick, i) => {
      pick.disabled = true;
      pick.setAttribute("aria-pressed", String(i === bin));
    });
    this.book = withGuess(this.book, this.nowMs, bin, this.replay.record.bin);
    local.setItem(KEY, JSON.stringify(this.book));
    byId("result").textContent = t("play.falls");
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (calm) this.#skip(this.book);
    else this.#since = performance.now();
    this.loop.wake();
  }

  /** Shows the landing without the fall. @param {Book} book */
  #skip(book) {
    this.#time = this.replay.duration;
    this.#end(book);
  }

  /** The ball has landed. @param {Book} book */
  #end({ guess, bin }) {
    this.picks.forEach((pick, i) => {
      pick.disabled = true;
      pick.setAttribute("aria-pressed", String(i === guess));
    });
    document.documentElement.dataset.lastBin = String(bin ?? "none");
    const result = byId("result");
    result.textContent = this.#words(guess, bin);
    result.style.setProperty("--paid", this.theme.payout(this.replay.record.score).fill);
    this.#showTally();
    const minutes = Math.ceil(untilNext(Date.now()) / 60_000);
    byId("next").textContent = t("today.next", { hours: Math.floor(minutes / 60), minutes: minutes % 60 });
    byId("share-text", HTMLTextAreaElement).value = this.#text();
    byId("after").hidden = false;
  }

  /** @param {number} guess @param {number | null} bin */
  #words(guess, bin) {
    if (bin === null) return t("play.rests");
    const { board, record } = this.replay;
    const pays = prizeOf(board, bin, record.score);
    return guess === bin ? t("today.hit", { pays }) : t("today.off", { n: Math.abs(guess - bin), pays });
  }

  #showTally() {
    byId("streak").textContent = plain(streakAt(this.book, this.nowMs));
    byId("best").textContent = plain(this.book?.best ?? 0);
    byId("right").textContent = t("today.of", { right: this.book?.right ?? 0, played: this.book?.played ?? 0 });
  }

  #text() {
    if (!this.book) return "";
    const lines = [
      `${t("today.headline")}, ${byId("date").textContent}`, marksOf(this.book),
      t("today.in-a-row", { n: this.book.streak }), new URL("today.html", document.baseURI).href,
    ];
    return lines.join("\n");
  }

  async #share() {
    const [text, note] = [byId("share-text", HTMLTextAreaElement), byId("share-note")];
    try {
      if (navigator.share) await navigator.share({ text: text.value });
      else {
        await navigator.clipboard.writeText(text.value);
        note.textContent = t("today.copied");
      }
    } catch {
      text.select(); // without permission the player copies it
      note.textContent = t("today.marked");
    }
  }

  /** @param {number} nowMs */
  #draw(nowMs) {
    const { replay, theme } = this;
    if (this.#since !== null) {
      this.#time = Math.max(0, nowMs - this.#since) / 1000;
      if (this.#time >= replay.duration && this.book && byId("after").hidden) this.#end(this.book);
    }
    this.stage.show(replay.sceneAt(this.#time), ({ ctx, geometry }) => {
      const width = Math.max(1.5, 0.2 * replay.board.ball.radius * geometry.scale);
      paintPath(ctx, geometry, replay.pathTo(this.#time), { colour: theme.palette.trayMark, width, alpha: 0.8 });
    });
    return this.#since !== null && this.#time < replay.end;
  }
}

openPage(async (theme) => {
  const { board, drop } = await dropOf(ballOfDay(Date.now()));
  new TodayPage(theme, await Replay.compute(board, drop));
});
