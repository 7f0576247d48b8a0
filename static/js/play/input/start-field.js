// About where the ball starts: in the middle, at an aim on a slider, or in one of the board's slots.

import { aimSpan } from "../../model/board.js";
import { t } from "../../texts/text.js";
import { byId, make, radioValue } from "../../util/dom.js";
import { fixed } from "../../util/format.js";

/** @import { Board } from "../../model/board.js" */
/** @import { KeptAims } from "./kept-aims.js" */

const SEED = "seed";
const CHOSEN = "chosen";
const COARSE = 1 / 24; // of the whole range, for one push of an arrow key
const FINE = 1 / 240; // with Shift

/** The "Start" field. `onChange()` tells that the aim has moved. */
export class StartField {
  /** @type {number[]} */
  #slots = [];
  /** @type {Board | null} */
  #board = null;

  /** @param {KeptAims} kept @param {() => void} onChange */
  constructor(kept, onChange) {
    this.kept = kept;
    this.chips = byId("start-chips");
    this.sliderBox = byId("start-slider");
    this.slider = byId("start-x", HTMLInputElement);
    this.told = byId("start-words");
    this.onChange = onChange;
    this.chips.addEventListener("change", () => this.#moved());
    this.slider.addEventListener("input", () => this.#moved());
  }

  /** @param {Board} board @param {number[]} slots */
  setBoard(board, slots) {
    this.#slots = slots;
    this.#board = board;
    this.told.textContent = "";
    const { x } = board.drop;
    const places = slots.length
      ? slots.map((_, index) => [String(index), String(index + 1), t("play.slot", { n: index + 1 })])
      : [[CHOSEN, t("word.aim"), t("word.aim")]];
    // A tenth of a millimetre inside, so that rounding never steps over the end.
    const reach = Math.max(0, Math.floor(aimSpan(board.drop) * 1e4 - 1) / 1e4);
    if (!slots.length && reach === 0) places.length = 0;
    this.chips.replaceChildren(
      chip(SEED, t("play.random"), t("play.random"), true),
      ...places.map(([value, text, name]) => chip(value, text, name, false)),
    );
    Object.assign(this.slider, { min: String(x - reach), max: String(x + reach), step: "any" });
    this.slider.value = String(x);
    this.#restore();
    this.#show();
  }

  /** The aim of the last time, where this board still allows it. */
  #restore() {
    const aim = this.#board && this.kept.of(this.#board);
    if (aim === null) return;
    if (this.#slots.length) this.#choose(String(this.#slots.indexOf(aim)));
    else if (aim >= Number(this.slider.min) && aim <= Number(this.slider.max)) {
      this.#choose(CHOSEN);
      this.slider.value = String(aim);
    }
  }

  /** @returns {number | null} middle of what the seed draws, metres; null for the board's own */
  get aim() {
    const value = this.#choice;
    if (value === SEED) return null;
    if (value === CHOSEN) return Math.round(Number(this.slider.value) * 1e4) / 1e4;
    return this.#slots[Number(value)];
  }

  /**
   * Moves the aim; the first push takes it from the seed.
   * @param {-1 | 1} side left or right @param {boolean} fine
   */
  nudge(side, fine) {
    if (this.#slots.length) this.#choose(String(this.#slotBeside(side)));
    else {
      const { min, max, value } = this.slider;
      const step = (Number(max) - Number(min)) * (fine ? FINE : COARSE);
      this.#choose(CHOSEN);
      this.slider.value = String(Number(value) + side * step);
    }
    this.#moved();
    this.told.textContent = this.#sentence();
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
    const off = (this.aim ?? middle) - middle;
    const size = fixed(Math.abs(off), 3);
    if (Math.abs(off) < 5e-4) return t("play.aim-middle");
    return off < 0 ? t("play.aim-left", { size }) : t("play.aim-right", { size });
  }

  /** @returns {string} */
  get #choice() {
    // Before the first board has come there is nothing to choose from.
    return this.chips.hasChildNodes() ? radioValue("start") : SEED;
  }

  #moved() {
    if (this.#board) this.kept.keep(this.#board, this.aim);
    this.#show();
  }

  #show() {
    this.sliderBox.hidden = this.#choice !== CHOSEN;
    this.onChange();
  }
}

/** @param {string} value @param {string} text @param {string} name @param {boolean} checked */
function chip(value, text, name, checked) {
  const input = make("input", { type: "radio", name: "start", value, "aria-label": name });
  input.checked = checked;
  return make("label", { class: "chip" }, input, make("span", {}, text));
}
