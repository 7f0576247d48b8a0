// The replay page: loads the drop that the address names, plays it, and shows the figures of each impact.

import { fillBoards, holdNumber, holdSeed, linkPages, openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { Chart } from "../instruments/chart.js";
import { provenWords } from "../model/certificate.js";
import { readBoardName } from "../model/presets.js";
import { hasServer } from "../net/ask.js";
import { packBoard } from "../net/board-link.js";
import { dropSearch, readDrop, replayLink } from "../net/drop-address.js";
import { paintPath, paintRing } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { t } from "../texts/text.js";
import { byId, fieldOf, fillFacts, inputOf, onClick, onSubmit } from "../util/dom.js";
import { metric, multiplier, seconds } from "../util/format.js";
import { FrameLoop, pause } from "../util/frame-loop.js";
import { figure } from "../util/scale.js";
import { offerFileCheck, offerVerify } from "./checks.js";
import { CloseUp, paintImpact } from "./closeup.js";
import { describeEnergy, energyPlot } from "./energy-plot.js";
import { Guess, guessWords } from "./guess.js";
import { ImpactList } from "./impact-list.js";
import { readShift } from "./pair.js";
import { dropOf, prove, Replay } from "./replay.js";
import { offerShare } from "./share.js";
import { Transport } from "./transport.js";

/** @import { Layer } from "../board/stage.js" */
/** @import { DropRecord } from "../model/motion/drop.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Fact } from "../util/dom.js" */

const PICK_REACH = 24; // how far from an impact a click may be, CSS pixels

class ReplayPage {
  /** @param {Theme} theme @param {Replay} replay @param {DropAddress} drop */
  constructor(theme, replay, drop) {
    this.theme = theme;
    this.replay = replay;
    const { board, motion, duration, end } = replay;
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.stage = new Stage(theme, wake);
    this.stage.setBoard(board);
    this.transport = new Transport({ duration, end, stops: motion.events.map(({ t }) => t) }, wake);
    this.list = new ImpactList(replay, (index) => this.#choose(index));
    this.guess = new Guess(board, () => this.transport.begin());
    this.energy = new Chart(byId("energy", HTMLCanvasElement), theme, (t) => this.transport.seek(t));
    this.closeUp = new CloseUp(byId("closeup", HTMLCanvasElement), theme, replay);
    this.withCloseUp = byId("with-closeup", HTMLInputElement);
    this.withHeight = byId("with-height", HTMLInputElement);
    this.withCloseUp.addEventListener("change", wake);
    this.withHeight.addEventListener("change", () => this.plotEnergy());
    byId("energy").setAttribute("aria-label", describeEnergy(motion));
    offerVerify(replay, this.list);
    onClick("certify", () => prove([drop], byId("verdict"), "replay.certifying", ([proof]) => (
      [proof.certified && proof.agrees ? "good" : "bad", provenWords(proof)])));
    byId("certify").hidden = drop.solver === "stepped";
    byId("board").addEventListener("pointerdown", (event) => this.#pick(event));
    for (const id of ["impact-back", "impact-on"]) onClick(id, () => this.#chooseAfterStep());
    document.addEventListener("keydown", (event) => {
      if (event.shiftKey && event.key.startsWith("Arrow")) this.#chooseAfterStep();
    });
  }

  /** @param {boolean} riddle whether the player guesses the bin first */
  begin(riddle) {
    if (riddle) this.guess.ask();
    else {
      this.#tell();
      this.transport.begin();
    }
  }

  /** Shows where the ball lands. @param {number | null} [guess] the guessed bin */
  #tell(guess = null) {
    const { board, record: { bin, score } } = this.replay;
    document.documentElement.dataset.lastBin = bin === null ? "none" : String(bin);
    const result = byId("result");
    result.textContent = bin === null
      ? t("replay.rests")
      : t("replay.lands", { bin, pays: prizeOf(board, bin, score) }) + guessWords(guess, bin);
    result.style.setProperty("--paid", this.theme.payout(score).fill);
  }

  /** @param {number} now */
  #draw(now) {
    const { replay, list, transport } = this;
    const t = transport.advance(now);
    if (this.guess.open && t >= replay.duration) this.#tell(this.guess.tell());
    this.energy.mark(Math.min(t, replay.duration));
    if (list.chosen >= 0 && t !== list.impacts[list.chosen].t) list.choose(-1);
    this.stage.show(replay.sceneAt(t), (layer) => this.#paintPath(layer, t), (layer) => this.#paintImpact(layer));
    this.#drawCloseUp(Math.min(t, replay.duration));
    list.follow(replay.motion.eventsBy(t) - 1);
    transport.show();
    return transport.playing;
  }

  plotEnergy() {
    this.energy.set(energyPlot(this.replay.motion, this.withHeight.checked));
  }

  /** @param {Layer} layer @param {number} t */
  #paintPath({ ctx, geometry }, t) {
    const { replay, theme: { palette: { trayMark: colour } } } = this;
    const width = Math.max(1.25, 0.16 * replay.board.ball.radius * geometry.scale);
    if (!this.guess.open) paintPath(ctx, geometry, replay.path, { colour, width, alpha: 0.3, dash: [2, 4] });
    paintPath(ctx, geometry, replay.pathTo(t), { colour, width: 1.4 * width, alpha: 0.85 });
  }

  /** Paints the chosen impact's normal and impulse at the point of contact. @param {Layer} layer */
  #paintImpact({ ctx, geometry: { px, py, scale } }) {
    const { replay, list: { impacts, chosen: index, strongest }, theme: { palette } } = this;
    const chosen = impacts[index];
    if (!chosen?.normal) return;
    const { normal, impulse, point } = chosen;
    const { x, y } = replay.motion.events[index].after;
    const radius = replay.board.ball.radius * scale;
    paintRing(ctx, px(x), py(y), radius + 3, { colour: palette.flash, width: 2 });
    const what = { normal, impulse, strongest, long: Math.max(44, 5 * radius) };
    paintImpact(ctx, { x: px(point.x), y: py(point.y) }, what, palette);
  }

  /** @param {number} t */
  #drawCloseUp(t) {
    const { replay, list, closeUp, stage: { geometry } } = this;
    closeUp.canvas.hidden = !this.withCloseUp.checked || this.guess.open; // the close-up shows the path ahead of the ball
    if (closeUp.canvas.hidden || !geometry) return;
    const state = replay.motion.stateAt(t);
    closeUp.avoid({ x: geometry.px(state.x), y: geometry.py(state.y) });
    closeUp.draw(state, list.impacts[list.chosen] ?? null, list.strongest);
  }

  /** @param {number} index */
  #choose(index) {
    const { told, t: time } = this.list.impacts[index];
    this.transport.seek(time);
    this.list.choose(index);
    byId("result").textContent = t("replay.chosen-impact", { n: index + 1, what: told, time: seconds(time) });
  }

  /** After a step from impact to impact, chooses the impact that was reached. */
  #chooseAfterStep() {
    const index = this.list.impacts.findIndex(({ t }) => t === this.transport.t);
    if (index >= 0) this.#choose(index);
  }

  /** @param {PointerEvent} event */
  #pick(event) {
    const { stage, guess, replay: { motion } } = this;
    const place = stage.aimOf(event);
    if (!place) return;
    if (guess.open) {
      guess.point(place);
      return;
    }
    const scale = stage.geometry?.scale ?? 0;
    let [best, reach] = [-1, PICK_REACH];
    motion.events.forEach(({ after }, i) => {
      const distance = scale * Math.hypot(after.x - place.x, after.y - place.y);
      if (distance < reach) [best, reach] = [i, distance];
    });
    if (best >= 0) this.#choose(best);
  }
}

/**
 * Shows what identifies the drop: in the page's head, in its facts, and in the form for another drop.
 * @param {Replay} replay @param {DropAddress} drop
 */
function showRecord({ record, board, motion }, drop) {
  const { bin, score, seed } = record;
  showState("replay", t("page.replay"));
  document.title = t("replay.title-seed", { seed: drop.seed, board: board.name });
  fillFacts(byId("facts"), [
    ["fact.board", board.name],
    ["fact.seed", seed],
    ["fact.start", record.x === undefined ? `${motion.start.x} m` : t("fact.start-practice", { x: String(motion.start.x) })],
    ...(record.aim === undefined ? [] : /** @type {Fact[]} */ ([["fact.aim", `${record.aim} m`]])),
    ["fact.solver", record.solver === "stepped"
      ? t("fact.solver-stepped", { dt: String(record.dt), substeps: String(record.substeps) })
      : t("fact.solver-exact")],
    ["fact.bin", bin === null ? t("word.none") : String(bin)],
    ["fact.score", bin === null ? t("fact.score-void") : multiplier(score)],
    ...(record.label === undefined ? [] : /** @type {Fact[]} */ ([["fact.prize", record.label]])),
    ["fact.duration", seconds(record.duration)],
    ["fact.impacts", String(record.impacts.length)],
    ...sureness(record),
    ["fact.digest", record.digest],
  ]);
}

/** The form for another drop. @param {DropAddress} drop @param {string} view */
function offerOther(drop, view) {
  linkPages(drop);
  const form = byId("other", HTMLFormElement);
  const [seedField, x] = [inputOf(form, "seed"), inputOf(form, "x")];
  const [other, solver] = [fieldOf(form, "board"), fieldOf(form, "solver")];
  seedField.value = drop.seed;
  x.value = String(drop.x ?? "");
  solver.value = drop.solver === "stepped" ? "stepped" : "";
  onSubmit("other", () => {
    if (!holdSeed(seedField, t("replay.needs-seed")) || !holdNumber(x)) return;
    const asked = { board: other.value, seed: seedField.value, x: x.value, solver: solver.value };
    window.location.assign(replayLink(asked) + (view && `&${view}`));
  });
}

/** @param {DropRecord} record @returns {Fact[]} how certain the bin is, if the server computed it */
function sureness({ amplification, x_error: error, certain }) {
  if (typeof amplification !== "number" || typeof error !== "number") return [];
  return [
    ["fact.chaotic", t("fact.chaotic-times", { times: figure(amplification) })],
    ["fact.accurate", error > 0 && error < 1 ? metric(error) : `${figure(error)} m`],
    ["fact.certain", certain ? t("fact.certain-yes") : t("fact.certain-no")],
  ];
}

/**
 * The form for a second ball to compare with.
 * @param {DropAddress} drop @param {URLSearchParams} search
 */
function offerComparison(drop, search) {
  const form = byId("versus", HTMLFormElement);
  const [seed, shift] = [inputOf(form, "with"), fieldOf(form, "shift")];
  seed.value = search.get("with") ?? "";
  shift.value = seed.value ? "seed" : readShift(search.get("shift"));
  const show = () => { byId("second").hidden = shift.value !== "seed"; };
  form.addEventListener("change", show);
  show();
  onSubmit("versus", () => {
    const seeded = shift.value === "seed";
    if (seeded && !holdSeed(seed, t("compare.needs-seed"), byId("versus-note"))) return;
    const { hash } = window.location; // may contain the board
    const asked = dropSearch({ ...drop, board: hash ? "" : drop.board });
    if (seeded) asked.set("with", seed.value);
    else asked.set("shift", shift.value);
    window.location.assign(`replay.html?${asked}&compare${hash}`);
  });
}

/** @returns {"" | "compare" | "embed"} what the address asks for instead of a plain replay; the server marks it too */
function viewOf(/** @type {URLSearchParams} */ search) {
  return search.has("embed") ? "embed" : search.has("compare") ? "compare" : "";
}

openPage(async (theme) => {
  const search = new URLSearchParams(window.location.search);
  if (search.has("today")) window.location.replace("today.html"); // a link of release 1.0
  const view = viewOf(search);
  document.documentElement.dataset.view = view;
  if (view === "embed") byId("drop").after(byId("result"));
  offerFileCheck();
  const { board, drop } = await dropOf(readDrop(search));
  offerOther(drop, view);
  offerComparison(drop, search);
  if (view === "embed") {
    const { embed } = await import("./embed.js");
    embed(theme, await Replay.compute(board, drop), drop);
    return;
  }
  if (view === "compare") {
    const { compare } = await import("./compare.js");
    byId("curious", HTMLDetailsElement).open = true;
    await compare(theme, board, drop, search);
  } else {
    const replay = await Replay.load(board, drop);
    await pause();
    const page = new ReplayPage(theme, replay, drop);
    await pause();
    page.plotEnergy();
    await pause();
    showRecord(replay, drop);
    // Another device does not know a board of this one.
    const contained = !hasServer && !readBoardName(drop.board) ? `#board=${await packBoard(board)}` : "";
    offerShare(drop, window.location.hash || contained, replay.record);
    page.begin(search.has("guess"));
  }
  await fillBoards(drop.board, board.name);
});
