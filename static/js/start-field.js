// Where the ball starts: left to the seed, chosen on a slider, or one of the board's slots.

import { byId, make } from "./dom.js";

const SEED = "seed";
const CHOSEN = "chosen";

/** The "Start" field. `onChange()` tells that the aim has moved. */
export class StartField {
  #slots = [];

  /** @param {() => void} onChange */
  constructor(onChange) {
    this.chips = byId("start-chips");
    this.sliderBox = byId("start-slider");
    this.slider = byId("start-x");
    this.onChange = onChange;
    this.chips.addEventListener("change", () => this.#show());
    this.slider.addEventListener("input", () => this.#show());
  }

  /** @param {any} board @param {number[]} slots */
  setBoard(board, slots) {
    this.#slots = slots;
    const { x, jitter } = board.drop;
    const places = slots.length
      ? slots.map((_, index) => [String(index), String(index + 1), `Slot ${index + 1}`])
      : [[CHOSEN, "I choose", "I choose"]];
    this.chips.replaceChildren(
      chip(SEED, "Seed decides", "Seed decides", true),
      ...places.map(([value, text, name]) => chip(value, text, name, false)),
    );
    // A tenth of a millimetre inside, so that rounding never steps over the end.
    const reach = Math.floor(jitter * 1e4 - 1) / 1e4;
    Object.assign(this.slider, { min: x - reach, max: x + reach, step: "any" });
    this.slider.value = String(x);
    this.#show();
  }

  /** @returns {number | null} metres, null when the seed decides */
  get x() {
    const value = this.#choice;
    if (value === SEED) return null;
    if (value === CHOSEN) return Math.round(Number(this.slider.value) * 1e4) / 1e4;
    return this.#slots[Number(value)];
  }

  get #choice() {
    // Before the first board has come there is nothing to choose from.
    return this.chips.querySelector("input:checked")?.value ?? SEED;
  }

  #show() {
    this.sliderBox.hidden = this.#choice !== CHOSEN;
    this.onChange();
  }
}

function chip(value, text, name, checked) {
  const input = make("input", { type: "radio", name: "start", value, "aria-label": name });
  input.checked = checked;
  return make("label", { class: "chip" }, input, make("span", {}, text));
}
