// The page for a class: one board or two, their numbers, and what the teacher asks; with the lesson of its address.

import { openPage, showState } from "../board/page.js";
import { messageOf } from "../net/api.js";
import { hasServer } from "../net/ask.js";
import { openSolver } from "../solver/solver.js";
import { language, t } from "../texts/text.js";
import { copyFrom } from "../util/copy.js";
import { byId, check, make, onChoice, onClick, parentOf, radioValue } from "../util/dom.js";
import { saveFile } from "../util/file.js";
import { fixed, metric, percent, plain } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { changed, readLesson, VIEWS, writeLesson } from "./lesson.js";
import { openPhones } from "./phones.js";
import { overlap } from "./statistics.js";
import { TrialView } from "./trial-view.js";
import { csvOf, Trial } from "./trial.js";
import { fillTable, LessonView, numbersOf, surpriseOf } from "./view.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Key } from "../texts/text.js" */
/** @import { Setting } from "./board.js" */
/** @import { Phones } from "./phones.js" */

const BETWEEN_MS = 100; // balls of "ten a second"
const REFRESH_MS = 250; // of the numbers
const LINKED_MS = 500; // after a change, until the address has it
const STEP = 5; // of a guess, by a key
/** @type {[Key, number][]} m/s² */
const GRAVITY = [["world.earth", 9.81], ["world.moon", 1.62], ["world.mars", 3.72], ["world.jupiter", 24.79]];
const BOUNCES = [0.5, 0.6, 0.7, 0.8, 0.9];
const HAIRS = [1e-4, 1e-6, 1e-9, 1e-12]; // m
const CHANCES = [0.3, 0.4, 0.5, 0.6, 0.7];

/** The page. */
class LessonPage {
  /** @type {Trial[]} */
  trials = [];
  /** @type {Phones | null} */
  phones = null;
  #secret = false; // whether the counts are hidden while the pupils guess
  /** @type {number | null} */
  #cursor = null;
  #nextBall = 0; // ms
  #refreshed = 0; // ms
  #landed = -1;
  #linking = 0;
  #calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  /** @param {Theme} theme @param {Solver} solver */
  constructor(theme, solver) {
    this.solver = solver;
    this.lesson = readLesson(window.location.hash);
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.boards = [0, 1].map((i) => new TrialView(`trial-${i}`, theme, wake));
    this.view = new LessonView(theme);
    theme.onChange(wake);
    document.addEventListener("visibilitychange", wake);
    this.#fillChoices();
    this.#wire();
    byId("phones").hidden = !hasServer;
  }

  /** Shows the lesson of the address, with the balls that it names. */
  show() {
    const { setting, change, view, size, guess, runs } = this.lesson;
    byId("rows", HTMLInputElement).value = String(setting.rows);
    byId("p", HTMLInputElement).value = String(setting.p);
    for (const [id, value] of Object.entries({ restitution: setting.restitution, gravity: setting.gravity, change })) {
      byId(id, HTMLSelectElement).value = String(value);
    }
    byId("size", HTMLInputElement).value = String(size);
    check("view", view);
    this.#secret = guess !== null && runs.length === 0;
    this.#showGuess();
    this.#setBoards(runs[0]?.seed);
    if (runs.length) for (const trial of this.trials) trial.restore(runs);
  }

  /** @param {number} [seed] */
  #setBoards(seed) {
    const { setting, change } = this.lesson;
    const second = changed(setting, change);
    const first = new Trial(this.solver, setting, seed);
    this.trials = second ? [first, new Trial(this.solver, second, first.run.seed)] : [first];
    for (const trial of this.trials) trial.calm = this.#calm.matches;
    [0, 1].forEach((i) => {
      const trial = this.trials[i];
      parentOf(byId(`trial-${i}`)).hidden = !trial;
      byId(`name-${i}`).textContent = trial && second ? nameOf(trial.setting, change) : "";
    });
    byId("rows-value").textContent = plain(setting.rows);
    byId("p-value").textContent = fixed(setting.p, 2);
    this.#refresh();
  }

  #fillChoices() {
    const option = (/** @type {string | number} */ value, /** @type {string} */ text) =>
      make("option", { value: String(value) }, text);
    byId("gravity").append(...GRAVITY.map(([key, value]) => option(value, t(key))));
    byId("restitution").append(...BOUNCES.map((value) => option(value, plain(value))));
    byId("hair").append(...HAIRS.map((value) => option(value, lengthOf(value))));
    byId("change").append(
      option("", t("class.no-second")),
      ...BOUNCES.map((value) => option(`restitution:${value}`, t("class.of-bounce", { value: plain(value) }))),
      ...GRAVITY.map(([key, value]) => option(`gravity:${value}`, t(key))),
      ...CHANCES.map((value) => option(`p:${value}`, t("class.of-p", { value: plain(value) }))),
    );
  }

  #wire() {
    onClick("drop", () => this.#drop(1));
    onClick("thousand", () => this.#drop(1000));
    onClick("stream", () => {
      const on = byId("stream").getAttribute("aria-pressed") !== "true";
      byId("stream").setAttribute("aria-pressed", String(on));
      this.#drop(0);
    });
    onClick("run", () => this.#each((trial, seed) => trial.begin(seed)));
    onClick("clear", () => {
      this.#each((trial, seed) => trial.clear(seed));
      this.#resetPhones();
    });
    onClick("twins", () => this.#twins());
    onClick("guess", () => this.#askGuess());
    onClick("copy", async () => {
      const copied = await copyFrom(byId("link", HTMLInputElement), new URL(this.#link(), window.location.href).href);
      byId("result").textContent = t(copied ? "class.copied" : "class.marked");
    });
    onClick("csv", () => saveFile("plinko-class.csv", csvOf(this.trials, language), "text/csv"));
    onClick("phones", () => void this.#openPhones());
    for (const id of ["rows", "p", "restitution", "gravity", "change", "size"]) {
      byId(id).addEventListener("input", () => this.#chosen(id));
    }
    onChoice("view", () => {
      this.lesson.view = VIEWS.find((view) => view === radioValue("view")) ?? "bins";
      this.#refresh();
    });
    onChoice("scope", () => this.#refresh());
    this.boards.forEach(({ canvas }, i) => {
      const point = (/** @type {PointerEvent} */ event) => this.#point(i, event);
      canvas.addEventListener("pointerdown", point);
      canvas.addEventListener("pointermove", (event) => event.buttons && point(event));
      canvas.addEventListener("keydown", (event) => this.#key(event));
    });
    window.addEventListener("hashchange", () => {
      this.lesson = readLesson(window.location.hash);
      this.show();
    });
  }

  /** @param {string} id of the field that was changed */
  #chosen(id) {
    const { lesson } = this;
    const { value } = /** @type {HTMLInputElement | HTMLSelectElement} */ (byId(id));
    if (id === "change") lesson.change = value;
    else if (id !== "size") lesson.setting = { ...lesson.setting, [id]: Number(value) };
    else lesson.size = readLesson(`#size=${value}`).size;
    if (id === "size") {
      this.#refresh();
      return;
    }
    this.#secret = lesson.guess !== null;
    if (id === "rows") lesson.guess = lesson.guess && new Array(lesson.setting.rows + 1).fill(0);
    this.#setBoards();
    this.#resetPhones();
  }

  #resetPhones() {
    this.phones?.reset(this.trials[0].board).catch((error) => this.#fail(error));
  }

  /** @param {(trial: Trial, seed: number | undefined) => void} act on each board, with the same seed */
  #each(act) {
    /** @type {number | undefined} */
    let seed;
    for (const trial of this.trials) {
      act(trial, seed);
      seed = trial.run.seed;
    }
    this.#refresh();
  }

  /** @param {number} balls */
  #drop(balls) {
    this.#secret = false;
    for (const trial of this.trials) {
      trial.calm = this.#calm.matches;
      trial.pair = [];
      trial.drop(balls);
    }
    this.loop.wake();
  }

  #twins() {
    const hair = Number(byId("hair", HTMLSelectElement).value);
    const [trial] = this.trials;
    trial.calm = this.#calm.matches;
    trial.twins(hair);
    const { parting } = trial;
    const apart = lengthOf(hair);
    byId("result").textContent = parting
      ? t("class.part", { apart, row: parting }) : t("class.never-part", { apart });
    byId("boards").scrollIntoView({ block: "nearest" });
    this.loop.wake();
  }

  #askGuess() {
    const on = this.lesson.guess === null;
    this.lesson.guess = on ? new Array(this.lesson.setting.rows + 1).fill(0) : null;
    this.#secret = on;
    this.#cursor = null;
    byId("stream").setAttribute("aria-pressed", "false");
    this.#showGuess();
    if (on) {
      this.#each((trial, seed) => trial.clear(seed));
      this.boards[0].canvas.focus();
    }
    this.#refresh();
  }

  #showGuess() {
    const on = this.lesson.guess !== null;
    byId("guess").setAttribute("aria-pressed", String(on));
    for (const { canvas } of this.boards) {
      canvas.tabIndex = on ? 0 : -1;
      canvas.role = on ? "application" : "img"; // then screen readers leave it the arrow keys
    }
  }

  /** @param {number} i of the board @param {PointerEvent} event */
  #point(i, event) {
    const at = this.#secret ? this.boards[i].pointed(event) : null;
    if (!at || !this.lesson.guess) return;
    this.boards[i].canvas.setPointerCapture(event.pointerId);
    this.#guessed(at.bin, at.height);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { guess } = this.lesson;
    if (!guess || !this.#secret) return;
    const across = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    const up = { ArrowDown: -STEP, ArrowUp: STEP }[event.key] ?? 0;
    if (!across && !up) return;
    event.preventDefault();
    const bin = Math.max(0, Math.min(guess.length - 1, (this.#cursor ?? 0) + across));
    this.#guessed(bin, Math.max(0, Math.min(100, guess[bin] + up)));
  }

  /** @param {number} bin @param {number} height */
  #guessed(bin, height) {
    if (!this.lesson.guess) return;
    this.lesson.guess[bin] = height;
    this.#cursor = bin;
    byId("result").textContent = t("class.guessed", { bin, height });
    this.loop.wake();
  }

  async #openPhones() {
    if (this.phones) return;
    try {
      this.phones = await openPhones(this.trials[0].board, {
        onBall: (seed, x) => {
          this.trials[0].enter(seed, x, true);
          this.#secret = false;
          this.loop.wake();
        },
        onPast: (drops) => {
          this.trials[0].clear();
          for (const { seed, x } of drops) this.trials[0].enter(seed, x, true, true);
          this.#refresh();
        },
      });
    } catch (error) {
      this.#fail(error);
    }
  }

  /** @param {unknown} error */
  #fail(error) {
    byId("result").textContent = messageOf(error);
  }

  get #all() {
    return radioValue("scope") === "all";
  }

  /** How many balls have landed on all boards. */
  get landed() {
    return this.trials.reduce((sum, { runs }) => runs.reduce((total, { bins }) => total + bins.length, sum), 0);
  }

  /** @returns {string} the lesson as the hash of a link */
  #link() {
    return writeLesson({ ...this.lesson, runs: this.trials[0].runs });
  }

  /** @param {number} now ms @returns {boolean} */
  #draw(now) {
    const streams = byId("stream").getAttribute("aria-pressed") === "true";
    if (streams && now >= this.#nextBall) {
      this.#nextBall = Math.max(now - BETWEEN_MS, this.#nextBall) + BETWEEN_MS;
      this.#drop(1);
    }
    const moves = this.trials.map((trial) => trial.advance(now)).some(Boolean);
    byId("result").ariaLive = moves || streams ? "off" : "polite"; // screen readers hear the end, not each ball
    const { guess } = this.lesson;
    this.trials.forEach((trial, i) =>
      this.boards[i].draw(trial, now, { all: this.#all, guess, secret: this.#secret, cursor: this.#cursor }));
    const { landed } = this;
    if (landed !== this.#landed && (!moves || now - this.#refreshed >= REFRESH_MS)) {
      this.#refreshed = now;
      this.#refresh();
    }
    return moves || streams;
  }

  /** Shows the numbers, the view and the link. */
  #refresh() {
    const { trials, lesson } = this;
    this.#landed = this.landed;
    const samples = trials.map((trial) => ({ ...trial.over(this.#all), settled: trial.settled(this.#all) }));
    fillTable("numbers", ...numbersOf(trials, samples));
    byId("numbers").dataset.boards = String(trials.length);
    const names = trials.length > 1 ? ["class.of-first", "class.of-second"] : [];
    byId("surprise").replaceChildren(...(this.#secret ? [] : trials.map((trial, i) => {
      const name = names[i] ? make("strong", {}, t(/** @type {Key} */ (names[i]))) : "";
      return make("p", {}, name, " ", surpriseOf(trial, samples[i]));
    })));
    this.view.show(lesson, trials, samples, this.#secret);
    const [{ counts, bins }] = samples;
    const result = byId("result");
    if (this.#secret) result.textContent = t("class.guess-now");
    else if (lesson.guess && bins.length) {
      result.textContent = t("class.guess-share", { share: percent(overlap(lesson.guess, counts), 0), n: bins.length });
    } else if (!trials[0].pair.length) result.textContent = t("class.landed", { n: bins.length });
    this.boards[0].canvas.setAttribute("aria-label", t("class.picture", { rows: lesson.setting.rows, n: bins.length }));
    this.boards[1].canvas.setAttribute("aria-label", t("class.picture-second"));
    // Browsers refuse many changes of the address in a short time, as a slider makes them.
    clearTimeout(this.#linking);
    this.#linking = setTimeout(() => window.history.replaceState(null, "", this.#link()), LINKED_MS);
    this.loop.wake();
  }
}

/** @param {number} metres @returns {string} "0.1 mm" */
const lengthOf = (metres) => (metres === HAIRS[0] ? `${plain(1000 * metres)} mm` : metric(metres));

/** @param {Setting} setting @param {string} change @returns {string} what tells the two boards apart */
function nameOf({ restitution, gravity, p }, change) {
  if (change.startsWith("restitution")) return t("class.of-bounce", { value: plain(restitution) });
  if (change.startsWith("p")) return t("class.of-p", { value: plain(p) });
  return t(GRAVITY.find(([, value]) => value === gravity)?.[0] ?? "word.gravity");
}

openPage(async (theme) => {
  const page = new LessonPage(theme, await openSolver());
  showState("live", t("play.ready"));
  page.show();
});
