// The game's colours and shapes: one file for CSS, canvas and pictures made elsewhere.

/** @typedef {Record<string, string>} Palette colour by name, as in theme.json */
/** @typedef {{from: number, fill: string, ink: string}} PayoutColour for scores >= from */

/**
 * Measures of what is drawn, in parts of a radius where they say nothing else.
 * @typedef {{across: number, down: number, alpha: number}} Shadow
 * @typedef {{x: number, y: number, radius: number}} Highlight
 * @typedef {{shadow: Shadow, highlight: Highlight, shade: {at: number, colour: string}[]}} PegShape
 * @typedef {{band: number, shadow: Shadow, highlight: Highlight,
 *   gloss: {at: number, colour: "light" | "dark", alpha: number}[]}} BallShape
 * @typedef {{metres: number, least: number, shade: number[]}} RailShape least: CSS pixels
 *
 * @typedef {object} Shapes
 * @property {number} rays
 * @property {PegShape} peg
 * @property {BallShape} ball
 * @property {{width: number, alpha: number}} trail
 * @property {RailShape} rail
 * @property {{pad: number, metres: number, least: number, most: number}} box CSS pixels, but metres
 */

/** Loads theme.json, follows the visitor's light or dark preference, sets the CSS variables. */
export class Theme {
  #dark = window.matchMedia("(prefers-color-scheme: dark)");

  /** @param {{light: Palette, dark: Palette, payout: PayoutColour[], shapes: Shapes}} data theme.json */
  constructor(data) {
    this.data = data;
    this.#apply();
  }

  /** @returns {Promise<Theme>} */
  static async load() {
    const response = await fetch(new URL("theme.json", document.baseURI));
    if (!response.ok) throw new Error(`theme.json: ${response.status}`);
    return new Theme(await response.json());
  }

  /** @type {Palette} */
  get palette() {
    return this.#dark.matches ? this.data.dark : this.data.light;
  }

  /** Measures of what is drawn, as in theme.json. */
  get shapes() {
    return this.data.shapes;
  }

  /** @param {() => void} listener called after the colours have changed */
  onChange(listener) {
    this.#dark.addEventListener("change", () => {
      this.#apply();
      listener();
    });
  }

  /** @param {number} score @returns {PayoutColour} */
  payout(score) {
    return payoutColour(this.data.payout, score);
  }

  #apply() {
    const { style } = document.documentElement;
    for (const [name, colour] of Object.entries(this.palette)) {
      style.setProperty(`--${kebab(name)}`, colour);
    }
  }
}

/** @param {PayoutColour[]} steps ascending @param {number} score @returns {PayoutColour} */
export function payoutColour(steps, score) {
  return steps.findLast((step) => score >= step.from) ?? steps[0];
}

/** @param {string} name */
function kebab(name) {
  return name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`);
}
