// Rows of sliders with their values and units; they tell of changes, and follow those of others.

import { make } from "../util/dom.js";
import { figure } from "../util/scale.js";

const TOLD_MS = 100; // while a slider is being drawn, its value is told this often

/**
 * @typedef {object} Dial
 * @property {string} name
 * @property {string} label
 * @property {number} low
 * @property {number} high
 * @property {string} unit
 * @property {number} [step] of a linear scale
 * @property {boolean} [log] equal ratios take equal ways; `low` is above 0
 * @property {(value: number) => string} [show]
 */

/** A column of sliders. */
export class Dials {
  #rows = new Map();

  /**
   * @param {HTMLElement} parent
   * @param {Dial[]} dials
   * @param {(name: string, value: number) => void} [onChange] also while it is drawn, now and then
   */
  constructor(parent, dials, onChange = () => {}) {
    this.onChange = onChange;
    parent.replaceChildren(...dials.map((dial) => this.#row(parent.id, dial)));
  }

  /** @param {string} name @returns {number} */
  value(name) {
    const { dial, input } = this.#rows.get(name);
    return dial.log ? exactOf(10 ** Number(input.value)) : Number(input.value);
  }

  /** Follows values that are known, but for a slider that is held. @param {Record<string, number>} values */
  set(values) {
    for (const [name, row] of this.#rows) {
      if (!(name in values) || row.held) continue;
      row.input.value = String(row.dial.log ? Math.log10(values[name]) : values[name]);
      this.#show(row, values[name]);
    }
  }

  /** @param {boolean} disabled */
  set disabled(disabled) {
    for (const { input } of this.#rows.values()) input.disabled = disabled;
  }

  #row(group, dial) {
    const id = `${group}-${dial.name}`;
    const [low, high] = dial.log ? [Math.log10(dial.low), Math.log10(dial.high)] : [dial.low, dial.high];
    const step = dial.log ? "0.01" : String(dial.step ?? "any");
    const input = make("input", { id, type: "range", min: String(low), max: String(high), step });
    const output = make("output", { for: id });
    const row = { dial, input, output, held: false, timer: 0, release: 0 };
    this.#rows.set(dial.name, row);
    input.addEventListener("input", () => this.#moved(row));
    input.addEventListener("change", () => this.#tell(row));
    this.#show(row, this.value(dial.name));
    return make("div", { class: "dial" }, make("label", { for: id }, dial.label), input, output);
  }

  #moved(row) {
    row.held = true;
    this.#show(row, this.value(row.dial.name));
    row.timer ||= setTimeout(() => this.#tell(row), TOLD_MS);
  }

  #tell(row) {
    clearTimeout(row.timer);
    row.timer = 0;
    this.onChange(row.dial.name, this.value(row.dial.name));
    // What the room answers to this must not pull the slider back from under the hand.
    clearTimeout(row.release);
    row.release = setTimeout(() => {
      row.held = false;
    }, 500);
  }

  #show({ dial, input, output }, value) {
    const text = dial.show ? dial.show(value) : `${figure(value)} ${dial.unit}`.trim();
    output.textContent = text;
    input.setAttribute("aria-valuetext", text);
  }
}

/** Three digits are all that a hand can mean. */
function exactOf(value) {
  return Number(value.toPrecision(3));
}
