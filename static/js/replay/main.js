// The replay page: loads the drop that the address names, plays it, shows what each impact did.

import { DEFAULT_BOARD, DEFAULT_SEED, fillBoards, holdSeeds, linkPages, openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { Chart } from "../instruments/chart.js";
import { provenWords } from "../model/certificate.js";
import { ApiError } from "../net/api.js";
import { readDrop, replayLink } from "../net/drop-address.js";
import { paintPath, paintRing } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { t } from "../texts/text.js";
import { byId, fieldOf, fillFacts, inputOf, say } from "../util/dom.js";
import { metric, multiplier, seconds } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { figure } from "../util/scale.js";
import { CloseUp, paintImpact } from "./closeup.js";
import { describeEnergy, energyPlot } from "./energy-plot.js";
import { FileCheck } from "./file-check.js";
import { Guess } from "./guess.js";
import { ImpactList } from "./impact-list.js";
import { boardOf, certificateOf, Replay } from "./replay.js";
import { dropOfDay, guessWords } from "./riddles.js";
import { Share } from "./share.js";
import { Transport } from "./transport.js";
import { Verifier } from "./verify.js";

/** @import { Layer } from "../board/stage.js" */
/** @import { DropRecord } from "../model/motion/drop.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Fact } from "../util/dom.js" */

const PICK_REACH = 24; // CSS pixels within which a click finds an impact

class ReplayPage {
  /** @type {Replay | null} */
  #replay = null;
  /** @type {DropAddress | null} */
  #drop = null;

  /** @param {Theme} theme */
  constructor(theme) {
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.stage = new Stage(theme, () => this.loop.wake());
    this.transport = new Transport(() => this.loop.wake());
    this.list = new ImpactList((index) => this.#choose(index));
    this.verifier = new Verifier(this.list);
    this.share = new Share();
    this.fileCheck = new FileCheck();
    this.guess = new Guess(() => this.transport.begin());
    this.energy = new Chart(byId("energy", HTMLCanvasElement), theme, (t) => this.transport.seek(t));
    this.closeUp = new CloseUp(byId("closeup", HTMLCanvasElement), theme);
    this.withCloseUp = byId("with-closeup", HTMLInputElement);
    this.withHeight = byId("with-height", HTMLInputElement);
    this.withCloseUp.addEventListener("change", () => this.loop.wake());
    this.withHeight.addEventListener("change", () => this.#plotEnergy());
    byId("verify").addEventListener("click", () => {
      if (this.#replay) this.verifier.verify(this.#replay);
    });
    byId("certify").addEventListener("click", () => this.#certify());
    byId("board").addEventListener("pointerdown", (event) => this.#pick(event));
    for (const id of ["impact-back", "impact-on"]) {
      byId(id).addEventListener("click", () => this.#chooseAfterStep());
    }
    document.addEventListener("keydown", (event) => {
      if (event.shiftKey && event.key.startsWith("Arrow")) this.#chooseAfterStep();
    });
  }

  /** @param {DropAddress} asked @param {string} hash @param {boolean} riddle whose end is guessed */
  async open(asked, hash, riddle) {
    const { board, address } = await boardOf(asked.board || DEFAULT_BOARD, hash);
    const drop = { ...asked, board: address, seed: asked.seed || DEFAULT_SEED };
    const replay = await Replay.load(board, drop);
    this.#replay = replay;
    this.#drop = drop;
    byId("certify").hidden = drop.solver === "stepped";
    this.stage.setBoard(board);
    this.list.load(replay);
    this.closeUp.load(replay);
    this.#plotEnergy();
    byId("energy").setAttribute("aria-label", describeEnergy(replay.motion));
    const stops = replay.motion.events.map(({ t }) => t);
    this.transport.load({ duration: replay.duration, end: replay.end, stops });
    this.#showRecord(replay, drop);
    this.share.load(drop, hash);
    if (riddle) this.guess.ask(board);
    else {
      this.#tell(replay);
      this.transport.begin();
    }
    await fillBoards(byId("other-board", HTMLSelectElement), { value: drop.board, name: board.name });
  }

  /** @param {Replay} replay @param {number | null} [guess] of its bin */
  #tell({ board, record: { bin, score, seed } }, guess = null) {
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    const result = byId("result");
    result.textContent = bin === null
      ? t("replay.rests", { seed })
      : t("replay.lands", { seed, bin, pays: prizeOf(board, bin, score) }) + guessWords(guess, bin);
    result.style.setProperty("--paid", this.theme.payout(score).fill);
  }

  /** @param {number} now */
  #draw(now) {
    const replay = this.#replay;
    if (!replay) return false;
    const t = this.transport.advance(now);
    if (this.guess.open && t >= replay.duration) this.#tell(replay, this.guess.tell());
    this.list.follow(replay.motion.eventsBy(t) - 1);
    this.energy.mark(Math.min(t, replay.duration));
    if (this.list.chosen >= 0 && t !== replay.motion.events[this.list.chosen].t) {
      this.list.choose(-1);
    }
    this.stage.draw(
      replay.sceneAt(t),
      (layer) => this.#paintPath(layer, replay, t),
      (layer) => this.#paintImpact(layer, replay, this.list.chosen),
    );
    this.#drawCloseUp(replay, Math.min(t, replay.duration));
    return this.transport.playing;
  }

  #plotEnergy() {
    if (this.#replay) this.energy.set(energyPlot(this.#replay.motion, this.withHeight.checked));
  }

  /** @param {Layer} layer @param {Replay} replay @param {number} t */
  #paintPath({ ctx, geometry }, replay, t) {
    const { palette } = this.theme;
    const width = Math.max(1.25, 0.16 * replay.board.ball.radius * geometry.scale);
    if (!this.guess.open) {
      paintPath(ctx, geometry, replay.path, { colour: palette.trayMark, width, alpha: 0.3, dash: [2, 4] });
    }
    paintPath(ctx, geometry, replay.pathTo(t), { colour: palette.trayMark, width: 1.4 * width, alpha: 0.85 });
  }

  /**
   * Normal and impulse at the point of contact, the impulse as long as it is strong.
   * @param {Layer} layer @param {Replay} replay @param {number} index
   */
  #paintImpact({ ctx, geometry: { px, py, scale } }, replay, index) {
    const { palette } = this.theme;
    const chosen = this.list.impacts[index];
    if (!chosen?.normal) return;
    const { normal, impulse, point } = chosen;
    const { x, y } = replay.motion.events[index].after;
    const radius = replay.board.ball.radius * scale;
    paintRing(ctx, px(x), py(y), radius + 3, { colour: palette.flash, width: 2 });
    const long = Math.max(44, 5 * radius);
    const what = { normal, impulse, strongest: this.list.strongest, long };
    paintImpact(ctx, { x: px(point.x), y: py(point.y) }, what, palette);
  }

  /** @param {Replay} replay @param {number} t */
  #drawCloseUp(replay, t) {
    const { geometry } = this.stage;
    const { canvas } = this.closeUp;
    canvas.hidden = !this.withCloseUp.checked || this.guess.open; // it shows the path ahead
    if (canvas.hidden || !geometry) return;
    const state = replay.motion.stateAt(t);
    const impact = this.list.chosen >= 0 ? this.list.impacts[this.list.chosen] : null;
    this.closeUp.avoid({ x: geometry.px(state.x), y: geometry.py(state.y) });
    this.closeUp.draw(state, replay.path, impact, this.list.strongest);
  }

  /** @param {number} index */
  #choose(index) {
    this.transport.seek(this.list.impacts[index].t);
    this.list.choose(index);
    const { told, t: time } = this.list.impacts[index];
    byId("result").textContent = t("replay.chosen-impact", { n: index + 1, what: told, time: seconds(time) });
  }

  /** After a step from impact to impact, the one that was reached is the chosen one. */
  #chooseAfterStep() {
    const index = this.#replay?.motion.events.findIndex(({ t }) => t === this.transport.t) ?? -1;
    if (index >= 0) this.#choose(index);
  }

  /** @param {PointerEvent} event */
  #pick(event) {
    const place = this.stage.placeOf(event);
    const scale = this.stage.geometry?.scale ?? 0;
    if (!this.#replay || !place) return;
    if (this.guess.open) {
      this.guess.point(this.#replay.board, place);
      return;
    }
    let [best, reach] = [-1, PICK_REACH];
    this.#replay.motion.events.forEach(({ after }, i) => {
      const distance = scale * Math.hypot(after.x - place.x, after.y - place.y);
      if (distance < reach) [best, reach] = [i, distance];
    });
    if (best >= 0) this.#choose(best);
  }

  /** @param {Replay} replay @param {DropAddress} drop */
  #showRecord({ record, board, motion }, drop) {
    const { bin, score, seed } = record;
    showState("replay", t("page.replay"));
    document.title = t("replay.title-seed", { seed: drop.seed, board: board.name });
    byId("title").textContent = t("replay.of-seed", { seed });
    linkPages(drop);
    fillFacts(byId("facts"), [
      ["fact.board", board.name],
      ["fact.seed", seed],
      ["fact.start", record.x === undefined ? `${motion.start.x} m` : t("fact.start-practice", { x: String(motion.start.x) })],
      ...(record.aim === undefined ? [] : /** @type {Fact[]} */ ([["fact.aim", `${record.aim} m`]])),
      ["fact.solver", solverWords(record)],
      ["fact.bin", bin === null ? t("word.none") : String(bin)],
      ["fact.score", bin === null ? t("fact.score-void") : multiplier(score)],
      ...(record.label === undefined ? [] : /** @type {Fact[]} */ ([["fact.prize", record.label]])),
      ["fact.duration", seconds(record.duration)],
      ["fact.impacts", String(record.impacts.length)],
      ...sureness(record),
      ["fact.digest", record.digest],
    ]);
    this.#fillForm(drop);
  }

  /** @param {DropAddress} drop */
  #fillForm(drop) {
    const form = byId("other", HTMLFormElement);
    const [seed, x] = [inputOf(form, "seed"), inputOf(form, "x")];
    const [board, solver] = [fieldOf(form, "board"), fieldOf(form, "solver")];
    seed.value = drop.seed;
    x.value = String(drop.x ?? "");
    solver.value = drop.solver === "stepped" ? "stepped" : "";
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (!holdSeeds([seed], t("replay.needs-seed"))) return;
      const asked = { board: board.value, seed: seed.value, x: x.value.trim(), solver: solver.value };
      window.location.assign(replayLink(asked));
    });
  }

  /** Asks for a proof of the bin, and shows it with its enclosure. */
  async #certify() {
    if (!this.#drop) return;
    const note = byId("verdict");
    say(note, "", t("replay.certifying"));
    try {
      const certificate = await certificateOf(this.#drop);
      say(note, certificate.certified && certificate.agrees ? "good" : "bad", provenWords(certificate));
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      say(note, "bad", error.message);
    }
  }
}

/** @param {DropRecord} record */
function solverWords({ solver, dt, substeps }) {
  if (solver !== "stepped") return t("fact.solver-exact");
  return t("fact.solver-stepped", { dt: String(dt), substeps: String(substeps) });
}

/** @param {DropRecord} record @returns {Fact[]} how sure the bin is, where the server says so */
function sureness({ amplification, x_error: error, certain }) {
  if (typeof amplification !== "number" || typeof error !== "number") return [];
  return [
    ["fact.chaotic", t("fact.chaotic-times", { times: figure(amplification) })],
    ["fact.accurate", error > 0 && error < 1 ? metric(error) : `${figure(error)} m`],
    ["fact.certain", certain ? t("fact.certain-yes") : t("fact.certain-no")],
  ];
}

openPage(async (theme) => {
  const page = new ReplayPage(theme);
  const search = new URLSearchParams(window.location.search);
  const today = search.has("today");
  const asked = today ? { ...readDrop(search), ...dropOfDay(new Date()) } : readDrop(search);
  await page.open(asked, window.location.hash, today || search.has("guess"));
  // Another board in the fragment is another drop, though the document stays the same.
  window.addEventListener("hashchange", () => window.location.reload());
});
