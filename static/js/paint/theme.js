// The game's colours and shapes from theme.json, which style sheets, canvases and the server's pictures share.

import DATA from "../../theme.json" with { type: "json" };
import { local } from "../util/storage.js";

/**
 * @typedef {typeof DATA} ThemeData
 * @typedef {Record<string, string>} Palette colour by name
 * @typedef {ThemeData["payout"][0]} PayoutColour for scores >= from
 *
 * Measures for painting, in radii unless said otherwise.
 * @typedef {ThemeData["shapes"]["ball"]} BallShape
 * @typedef {ThemeData["shapes"]["peg"] & {mark?: Mark[]}} PegShape mark: shapes that paint/peg.js paints over the peg
 * @typedef {{shape: "disc" | "ring" | "stripe" | "line", at: number[], colour: string, alpha: number}} Mark
 *   at, by shape: x, y and radius; radius and width; y and height; both ends and width
 * @typedef {Omit<ThemeData["shapes"], "peg"> & {peg: PegShape}} Shapes of the trail, only the player's own balls have a
 *   core; box: in CSS pixels, except `metres`
 *
 * @typedef {ThemeData["grounds"]} Grounds measures for paint/ground.js
 * @typedef {Grounds["craters"]["around"]["planets"][0]} Planet colours: from the lit side to the dark one
 * @typedef {{ground: string, palette: Palette, peg: Partial<PegShape>}} Place the changes that a world makes to the
 *   look; ground: its backdrop
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

  constructor() {
    this.#scheme = schemeOf(local.getItem(KEY));
    this.#look = this.#apply();
    this.#system.addEventListener("change", () => this.#change());
    window.addEventListener("storage", ({ key, newValue }) => {
      if (key !== KEY) return;
      this.#scheme = schemeOf(newValue);
      this.#change();
    });
  }

  get scheme() {
    return this.#scheme;
  }

  /** @param {Scheme} scheme for all pages of this browser */
  choose(scheme) {
    this.#scheme = scheme;
    local.setItem(KEY, scheme);
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
    const dark = this.#scheme === "dark" || (this.#scheme === "system" && this.#system.matches);
    return lookOf(DATA, dark ? DATA.dark : DATA.light, place);
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
    return DATA.grounds;
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
  const own = place === null ? null : /** @type {Record<string, Place>} */ (data.places)[place];
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
