// The game's colours and shapes from theme.json, which style sheets, canvases and the server's pictures share.

import { local } from "../util/storage.js";

/** @typedef {Record<string, string>} Palette colour by name, as in theme.json */
/** @typedef {{from: number, fill: string, ink: string}} PayoutColour for scores >= from */

/**
 * Measures for painting, in radii unless said otherwise.
 * @typedef {{across: number, down: number, alpha: number}} Shadow
 * @typedef {{x: number, y: number, radius: number}} Highlight
 * @typedef {{shadow: Shadow, highlight: Highlight, shade: {at: number, colour: string}[], mark?: Mark[]}} PegShape mark:
 *   shapes that paint/peg.js paints over the peg
 * @typedef {{shape: "disc" | "ring" | "stripe" | "line", at: number[], colour: string, alpha: number}} Mark
 *   at, by shape: x, y and radius; radius and width; y and height; both ends and width
 * @typedef {{band: number, shadow: Shadow, highlight: Highlight,
 *   gloss: {at: number, colour: "light" | "dark", alpha: number}[]}} BallShape
 * @typedef {{metres: number, least: number, shade: number[]}} RailShape least: CSS pixels
 *
 * @typedef {object} Shapes
 * @property {number} rays
 * @property {PegShape} peg
 * @property {BallShape} ball
 * @property {{width: number, alpha: number, core: {width: number, alpha: number, part: number}}} trail part:
 *   of the trail's length; only the player's own balls have a core
 * @property {RailShape} rail
 * @property {{pad: number, metres: number, least: number, most: number}} box in CSS pixels, except `metres`
 *
 * @typedef {{x: number, y: number, size: number, colours: string[]}} Planet colours: from the lit side to the dark one
 * @typedef {object} Grounds measures for paint/ground.js
 * @property {number} step
 * @property {{plate: {count: number, least: number, more: number, alpha: number,
 *   rim: {shift: number, size: number, alpha: number}}, around: {stars: number, planets: Planet[]}}} craters
 * @property {{plate: {count: number, top: number, reach: number, swell: number,
 *   ripple: {part: number, times: number}, alphas: number[]}, around: {stars: number, planets: Planet[]}}} dunes
 * @property {{plate: {top: number, between: number, thick: number[], alphas: number[],
 *   edges: {swell: number, times: number, shift: number}[],
 *   spot: {x: number, y: number, across: number, down: number, colour: string, rings: number[][]}},
 *   around: {stars: number, planets: Planet[]}}} bands
 * @property {{plate: {beams: number, side: number, slant: number, alpha: number, line: number},
 *   around: {beams: number}, beams: {slant: number, dim: number, at: number[][]}}} panes
 * @property {{plate: {every: number, alphas: number[], seams: number[], seam: {high: number, alpha: number},
 *   rivets: {count: number, above: number, size: number, alpha: number}}, around: {stripe: number}}} plates
 * @property {{plate: {y: number, circle: number, goal: number, line: number, alpha: number},
 *   around: {y: number, reach: number, high: number, bounces: number, nearer: number, lower: number, line: number,
 *   dash: number}}} court
 *
 * @typedef {{ground: string, palette: Palette, peg: Partial<PegShape>}} Place the changes that a world makes to the
 *   look; ground: its backdrop
 * @typedef {{light: Palette, dark: Palette, payout: PayoutColour[], shapes: Shapes, places: Record<string, Place>,
 *   grounds: Grounds}}
 *   ThemeData theme.json
 *
 * @typedef {object} Look everything that painting a board needs
 * @property {Palette} palette
 * @property {Shapes} shapes
 * @property {string} ground
 * @property {Grounds} grounds
 * @property {(score: number) => PayoutColour} payout
 */

/** @typedef {"system" | "light" | "dark"} Scheme */

const KEY = "plinko.scheme.1";
const KEPT_S = 365 * 24 * 3600; // lifetime of the cookie that tells the server the page's first colours
/** @type {Scheme[]} */
export const SCHEMES = ["system", "light", "dark"];

/** The page's look: light or dark as the visitor or the system chose. It sets the CSS variables. */
export class Theme {
  #system = window.matchMedia("(prefers-color-scheme: dark)");
  /** @type {(() => void)[]} */
  #listeners = [];
  /** @type {Scheme} */
  #scheme;
  /** @type {string | null} the place of the current board; null for the default look */
  #place = null;
  /** @type {Look} */
  #look;

  /** @param {ThemeData} data @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(data, storage = local) {
    this.data = data;
    this.storage = storage;
    this.#scheme = schemeOf(storage.getItem(KEY));
    this.#look = this.#apply();
    this.#system.addEventListener("change", () => this.#change());
    window.addEventListener("storage", ({ key, newValue }) => {
      if (key !== KEY) return;
      this.#scheme = schemeOf(newValue);
      this.#change();
    });
  }

  /** @returns {Promise<Theme>} */
  static async load() {
    const response = await fetch(new URL("theme.json", document.baseURI));
    if (!response.ok) throw new Error(`theme.json: ${response.status}`);
    return new Theme(await response.json());
  }

  get scheme() {
    return this.#scheme;
  }

  /** @param {Scheme} scheme for all pages of this browser */
  choose(scheme) {
    this.#scheme = scheme;
    this.storage.setItem(KEY, scheme);
    document.cookie = `scheme=${scheme}; max-age=${KEPT_S}; samesite=lax`;
    this.#change();
  }

  /** @param {string | null} place of the board that is shown */
  enter(place) {
    if (place === this.#place) return;
    this.#place = place;
    this.#change();
  }

  /** @param {string | null} place @returns {Look} the current look of boards in that place */
  lookOf(place) {
    const { data } = this;
    const dark = this.#scheme === "dark" || (this.#scheme === "system" && this.#system.matches);
    return lookOf(data, dark ? data.dark : data.light, place);
  }

  /** @type {Palette} */
  get palette() {
    return this.#look.palette;
  }

  /** As in theme.json. */
  get shapes() {
    return this.#look.shapes;
  }

  get ground() {
    return this.#look.ground;
  }

  /** As in theme.json. */
  get grounds() {
    return this.data.grounds;
  }

  /** @param {() => void} listener called after the colours have changed */
  onChange(listener) {
    this.#listeners.push(listener);
  }

  /** @param {number} score @returns {PayoutColour} */
  payout(score) {
    return this.#look.payout(score);
  }

  #change() {
    this.#look = this.#apply();
    for (const listener of this.#listeners) listener();
  }

  /** @returns {Look} */
  #apply() {
    const look = this.lookOf(this.#place);
    const { style, dataset } = document.documentElement;
    const shown = getComputedStyle(document.documentElement);
    const wrong = Object.entries(look.palette).filter(([name, colour]) =>
      shown.getPropertyValue(`--${kebab(name)}`) !== colour);
    for (const [name, colour] of wrong) style.setProperty(`--${kebab(name)}`, colour); // each restyles the whole page
    style.colorScheme = this.#scheme === "system" ? "" : this.#scheme;
    dataset.ground = look.ground;
    return look;
  }
}

/**
 * @param {ThemeData} data
 * @param {Palette} palette the default one, light or dark
 * @param {string | null} place
 * @returns {Look}
 */
export function lookOf(data, palette, place) {
  const own = place === null ? null : data.places[place];
  return {
    palette: { ...palette, ...own?.palette },
    shapes: { ...data.shapes, peg: { ...data.shapes.peg, ...own?.peg } },
    ground: own?.ground ?? "rays",
    grounds: data.grounds,
    payout: (score) => payoutColour(data.payout, score),
  };
}

/** @param {PayoutColour[]} steps ascending @param {number} score @returns {PayoutColour} */
export function payoutColour(steps, score) {
  return steps.findLast((step) => score >= step.from) ?? steps[0];
}

/** @param {string | null} text as stored @returns {Scheme} */
function schemeOf(text) {
  return SCHEMES.find((scheme) => scheme === text) ?? "system";
}

/** @param {string} name */
function kebab(name) {
  return name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`);
}
