// The game's colours and shapes: one file for CSS, canvas and pictures made elsewhere.

/** @typedef {Record<string, string>} Palette colour by name, as in theme.json */
/** @typedef {{from: number, fill: string, ink: string}} PayoutColour for scores >= from */

/** Loads theme.json, follows the visitor's light or dark preference, sets the CSS variables. */
export class Theme {
  #dark = window.matchMedia("(prefers-color-scheme: dark)");

  /** @param {{light: Palette, dark: Palette, payout: PayoutColour[], shapes: any}} data theme.json */
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

function kebab(name) {
  return name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`);
}
