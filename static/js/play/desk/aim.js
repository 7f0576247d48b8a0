// The field "Start": the ball starts at random, at an aim set on a slider, or in one of the board's slots. It is
// offered only where the aim can move the ball by at least its radius.

import { aimSpan, allowedAim } from "../../model/board.js";
import { t } from "../../texts/text.js";
import { byId, check, chip, isWithin, onClick, radioValue } from "../../util/dom.js";
import { fixed } from "../../util/format.js";
import { readStored } from "../../util/stored.js";
import { onKey } from "./keys.js";

/** @import { Board } from "../../model/board.js" */
/** @import { Hello } from "../../model/messages.js" */
/** @import { Game } from "../game.js" */

const SEED = "seed";
const CHOSEN = "chosen";
const COARSE = 1 / 24; // of the whole range, for one push of an arrow key
const FINE = 1 / 240; // with Shift
const KEY = "plinko.aims.1";
const KEPT = 20; // boards

/** @typedef {Pick<Storage, "getItem" | "setItem">} Kept */

/** @param {Kept} storage @returns {[string, number][]} pairs of board name and aim; the last changed at the end */
const keptAims = (storage) => readStored(storage, KEY, isAims) ?? [];

/** @param {unknown} value @returns {value is [string, number][]} */
function isAims(value) {
  return Array.isArray(value) && value.every((pair) =>
    Array.isArray(pair) && typeof pair[0] === "string" && Number.isFinite(pair[1]));
}

/** @param {Kept} storage @param {string} name of a board @returns {number | null} m; null without one */
export function keptAim(storage, name) {
  return keptAims(storage).find(([board]) => board === name)?.[1] ?? null;
}

/** @param {Kept} storage @param {string} name of a board @param {number | null} aim m; null deletes it */
export function keepAim(storage, name, aim) {
  const others = keptAims(storage).filter(([board]) => board !== name);
  const all = aim === null ? others : [...others, [name, aim]];
  storage.setItem(KEY, JSON.stringify(all.slice(-KEPT)));
}

/** @param {Board} board @param {number[]} slots @returns {boolean} whether the board can be aimed at */
export function aims(board, slots) {
  return slots.length > 0 || aimSpan(board.drop) >= board.ball.radius;
}

/** The field "Start", and the arrow keys. */
export class Aim {
  /** @type {number[]} */
  #slots = [];
  /** @type {Board | null} */
  #board = null;

  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.field = byId("start");
    this.slider = byId("start-x", HTMLInputElement);
    this.words = byId("start-words");
    this.field.addEventListener("change", () => this.#moved());
    this.slider.addEventListener("input", () => this.#moved());
    onClick("practice-end", () => {
      check("start", SEED);
      this.#moved();
    });
    onKey(["arrowleft", "arrowright"], (event) => this.#key(event));
    let digest = "";
    game.on("table", ({ hello }) => {
      const key = hello.draw?.digest ?? hello.board_digest;
      if (digest !== key) this.#setBoard(hello);
      digest = key;
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
      ? slots.map((_, index) => chip("start", String(index), String(index + 1), t("play.slot", { n: index + 1 })))
      : [chip("start", CHOSEN, t("word.aim"))];
    byId("start-chips").replaceChildren(chip("start", SEED, t("play.random")), ...places);
    check("start", SEED);
    // A tenth of a millimetre less than allowed, so that a rounded aim never exceeds the range.
    const reach = Math.max(0, Math.floor(aimSpan(board.drop) * 1e4 - 1) / 1e4);
    Object.assign(this.slider, { min: String(x - reach), max: String(x + reach), step: "any" });
    this.slider.value = String(x);
    const aim = this.field.hidden ? null : keptAim(this.game.storage, board.name);
    if (aim !== null) this.#restore(aim);
    this.#show();
  }

  /** Sets the stored aim if this board allows it. @param {number} aim */
  #restore(aim) {
    if (this.#slots.includes(aim)) check("start", this.#slots.indexOf(aim));
    else if (!this.#slots.length && aim >= Number(this.slider.min) && aim <= Number(this.slider.max)) {
      check("start", CHOSEN);
      this.slider.value = String(aim);
    }
  }

  /** @returns {string} */
  get #choice() {
    return this.field.hidden ? SEED : radioValue("start");
  }

  /** @returns {number | null} the middle of the starts that seeds draw, m; null for the board's default */
  get #aim() {
    const value = this.#choice;
    if (value === SEED) return null;
    if (value === CHOSEN) return Math.round(Number(this.slider.value) * 1e4) / 1e4;
    return this.#slots[Number(value)];
  }

  /** Arrow keys aim, unless the focused element uses them itself. @param {KeyboardEvent} event */
  #key(event) {
    if (this.field.hidden || !this.#board || isWithin(event, "input")) return;
    event.preventDefault();
    const side = event.key === "ArrowLeft" ? -1 : 1;
    // The first press switches from a random start to an aim.
    if (this.#slots.length) check("start", this.#slotBeside(side));
    else {
      const { min, max, value } = this.slider;
      check("start", CHOSEN);
      const step = (Number(max) - Number(min)) * (event.shiftKey ? FINE : COARSE);
      this.slider.value = String(Number(value) + side * step);
    }
    this.#moved();
    this.words.textContent = this.#sentence(this.#board);
  }

  /** @param {number} side */
  #slotBeside(side) {
    const middle = (this.#slots.length - 1) / 2;
    const now = this.#choice === SEED ? middle - side * (middle % 1 === 0 ? 1 : 0.5) : Number(this.#choice);
    return Math.max(0, Math.min(this.#slots.length - 1, now + side));
  }

  /** @param {Board} board @returns {string} the aim in words, for screen readers */
  #sentence({ drop: { x } }) {
    if (this.#slots.length) return t("play.aim-slot", { n: Number(this.#choice) + 1 });
    const off = (this.#aim ?? x) - x;
    const size = fixed(Math.abs(off), 3);
    if (Math.abs(off) < 5e-4) return t("play.aim-middle");
    return off < 0 ? t("play.aim-left", { size }) : t("play.aim-right", { size });
  }

  #moved() {
    if (this.#board) keepAim(this.game.storage, this.#board.name, this.#aim);
    this.#show();
  }

  #show() {
    byId("start-slider").hidden = this.#choice !== CHOSEN;
    this.game.choose({ aim: this.#aim });
    this.game.tell("picture", null);
  }
}

/** @param {Hello} hello @param {number} x m @returns {number | null} the aim of a click; null in a draw */
export function aimAt({ board, slots, draw }, x) {
  return !draw && aims(board, slots) ? allowedAim(board, slots, x) : null;
}
