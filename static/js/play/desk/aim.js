// Where the ball starts: by chance, at an aim on a slider, or in one of the board's slots. Offered only where an
// aim moves the ball by its own radius at least.

import { aimSpan, allowedAim } from "../../model/board.js";
import { t } from "../../texts/text.js";
import { byId, isWithin, make, radioValue } from "../../util/dom.js";
import { fixed } from "../../util/format.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Hello } from "../../model/messages.js" */
/** @import { Game } from "../game.js" */

const SEED = "seed";
const CHOSEN = "chosen";
const COARSE = 1 / 24; // of the whole range, for one push of an arrow key
const FINE = 1 / 240; // with Shift
const KEY = "plinko.aims.1";
const KEPT = 20; // boards

/** Aims by the boards' names, found again in another tab, another day. */
export class KeptAims {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {[string, number][]} the last changed at the end */
  get #all() {
    return JSON.parse(this.storage.getItem(KEY) ?? "[]");
  }

  /** @param {Pick<Board, "name">} board @returns {number | null} metres; null where nobody aimed */
  of({ name }) {
    return this.#all.find(([board]) => board === name)?.[1] ?? null;
  }

  /** @param {Pick<Board, "name">} board @param {number | null} aim metres; null forgets */
  keep({ name }, aim) {
    const others = this.#all.filter(([board]) => board !== name);
    const all = aim === null ? others : [...others, [name, aim]];
    this.storage.setItem(KEY, JSON.stringify(all.slice(-KEPT)));
  }
}

/** @param {Board} board @param {number[]} slots @returns {boolean} whether an aim there makes a difference */
export function aims(board, slots) {
  return slots.length > 0 || aimSpan(board.drop) >= board.ball.radius;
}

/** The field "Start", and the arrow keys. */
export class Aim {
  /** @type {number[]} */
  #slots = [];
  /** @type {Board | null} */
  #board = null;
  #digest = "";

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.kept = new KeptAims(game.storage);
    this.field = byId("start");
    this.chips = byId("start-chips");
    this.sliderBox = byId("start-slider");
    this.slider = byId("start-x", HTMLInputElement);
    this.words = byId("start-words");
    this.chips.addEventListener("change", () => this.#moved());
    this.slider.addEventListener("input", () => this.#moved());
    document.addEventListener("keydown", (event) => this.#key(event));
    game.on("table", ({ hello }) => {
      const key = hello.draw?.digest ?? hello.board_digest;
      if (this.#digest !== key) this.#setBoard(hello);
      this.#digest = key;
    });
  }

  /** @param {Hello} hello */
  #setBoard({ board, slots, draw }) {
    this.#slots = slots;
    this.#board = board;
    this.words.textContent = "";
    this.field.hidden = draw !== undefined || !aims(board, slots);
    const { x } = board.drop;
    const places = slots.length
      ? slots.map((_, index) => [String(index), String(index + 1), t("play.slot", { n: index + 1 })])
      : [[CHOSEN, t("word.aim"), t("word.aim")]];
    // A tenth of a millimetre inside, so that rounding never steps over the end.
    const reach = Math.max(0, Math.floor(aimSpan(board.drop) * 1e4 - 1) / 1e4);
    this.chips.replaceChildren(
      chip(SEED, t("play.random"), t("play.random"), true),
      ...places.map(([value, text, name]) => chip(value, text, name, false)),
    );
    Object.assign(this.slider, { min: String(x - reach), max: String(x + reach), step: "any" });
    this.slider.value = String(x);
    if (!this.field.hidden) this.#restore(board);
    this.#show();
  }

  /** The aim of the last time, where this board still allows it. @param {Board} board */
  #restore(board) {
    const aim = this.kept.of(board);
    if (aim === null) return;
    if (this.#slots.length) this.#choose(String(this.#slots.indexOf(aim)));
    else if (aim >= Number(this.slider.min) && aim <= Number(this.slider.max)) {
      this.#choose(CHOSEN);
      this.slider.value = String(aim);
    }
  }

  /** @returns {number | null} middle of what the seed draws, metres; null for the board's own */
  get #aim() {
    const value = this.#choice;
    if (value === SEED) return null;
    if (value === CHOSEN) return Math.round(Number(this.slider.value) * 1e4) / 1e4;
    return this.#slots[Number(value)];
  }

  /**
   * Moves the aim; the first push takes it from the seed.
   * @param {-1 | 1} side left or right @param {boolean} fine
   */
  #nudge(side, fine) {
    if (this.#slots.length) this.#choose(String(this.#slotBeside(side)));
    else {
      const { min, max, value } = this.slider;
      const step = (Number(max) - Number(min)) * (fine ? FINE : COARSE);
      this.#choose(CHOSEN);
      this.slider.value = String(Number(value) + side * step);
    }
    this.#moved();
    this.words.textContent = this.#sentence();
  }

  /** @param {number} side */
  #slotBeside(side) {
    const middle = (this.#slots.length - 1) / 2;
    const now = this.#choice === SEED ? middle - side * (middle % 1 === 0 ? 1 : 0.5) : Number(this.#choice);
    return Math.max(0, Math.min(this.#slots.length - 1, now + side));
  }

  /** @param {string} value */
  #choose(value) {
    const radio = [...this.chips.querySelectorAll("input")].find((input) => input.value === value);
    if (radio) radio.checked = true;
  }

  /** @returns {string} the place as a sentence, for those who do not see the ball over the board. */
  #sentence() {
    if (this.#slots.length) return t("play.aim-slot", { n: Number(this.#choice) + 1 });
    const middle = this.#board?.drop.x ?? 0;
    const off = (this.#aim ?? middle) - middle;
    const size = fixed(Math.abs(off), 3);
    if (Math.abs(off) < 5e-4) return t("play.aim-middle");
    return off < 0 ? t("play.aim-left", { size }) : t("play.aim-right", { size });
  }

  /** @returns {string} */
  get #choice() {
    return this.field.hidden ? SEED : radioValue("start");
  }

  #moved() {
    if (this.#board) this.kept.keep(this.#board, this.#aim);
    this.#show();
  }

  #show() {
    this.sliderBox.hidden = this.#choice !== CHOSEN;
    this.game.choose({ aim: this.#aim });
    this.game.tell("picture", null);
  }

  /** Arrows aim from anywhere that has no use of its own for them. @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.field.hidden || !this.#board) return;
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    if (isWithin(event, "input, select, textarea, dialog")) return;
    event.preventDefault();
    this.#nudge(event.key === "ArrowLeft" ? -1 : 1, event.shiftKey);
  }
}

/** @param {Hello} hello @param {number} x m @returns {number | null} where a click there aims; in a draw nobody does */
export function aimAt({ board, slots, draw }, x) {
  return !draw && aims(board, slots) ? allowedAim(board, slots, x) : null;
}

/** @param {string} value @param {string} text @param {string} name @param {boolean} checked */
function chip(value, text, name, checked) {
  const input = make("input", { type: "radio", name: "start", value, "aria-label": name });
  input.checked = checked;
  return make("label", { class: "chip" }, input, make("span", {}, text));
}
