// Caches the stamps of balls, one set for each colour, made when a ball of that colour is first drawn.

import { makeHalo, makeSprite } from "./ball.js";

/** @import { SceneBall } from "../model/scene.js" */
/** @import { BallColours, Light, Sprite } from "./ball.js" */
/** @import { Theme } from "./theme.js" */

const MOST = 32; // sets; bounded, because players choose colours freely

/** @typedef {{colour: string, body: Sprite, halo: Light}} Stamps colour: of halo and trail */

/** The stamps for one size, one screen density and one theme. */
export class StampBook {
  /** @type {Map<string, Stamps>} */
  #sets = new Map();

  /** @param {number} radius CSS pixels @param {number} density @param {Pick<Theme, "palette" | "shapes">} theme */
  constructor(radius, density, theme) {
    this.radius = radius;
    this.density = density;
    this.theme = theme;
  }

  /** @param {Pick<SceneBall, "mine" | "colour">} ball @returns {Stamps} */
  of({ mine, colour }) {
    const key = colour ?? (mine ? "mine" : "other");
    const made = this.#sets.get(key);
    if (made) return made;
    if (this.#sets.size === MOST) this.#sets.clear();
    const stamps = this.#make(coloursOf(this.theme.palette, mine, colour));
    this.#sets.set(key, stamps);
    return stamps;
  }

  /** @param {BallColours} colours @returns {Stamps} */
  #make(colours) {
    const { radius, density, theme } = this;
    return {
      colour: colours.body,
      body: makeSprite(radius, density, colours, theme.shapes.ball),
      halo: makeHalo(radius, density, colours.body),
    };
  }
}

/**
 * @param {Theme["palette"]} palette
 * @param {boolean} mine
 * @param {string} [chosen] #rrggbb
 * @returns {BallColours}
 */
function coloursOf(palette, mine, chosen) {
  const { shadow } = palette;
  if (chosen) {
    const dark = shaded(chosen);
    return { body: chosen, dark, light: "#ffffff", band: mine ? palette.ballBand : dark, shadow };
  }
  if (mine) {
    const { ball: body, ballDark: dark, ballLight: light, ballBand: band } = palette;
    return { body, dark, light, band, shadow };
  }
  const { other: body, otherDark: dark } = palette;
  return { body, dark, light: "#ffffff", band: dark, shadow };
}

/** @param {string} colour #rrggbb @param {number} [part] of its brightness @returns {string} the same, darker */
export function shaded(colour, part = 0.5) {
  const parts = [1, 3, 5].map((at) => Math.round(part * parseInt(colour.slice(at, at + 2), 16)));
  return `#${parts.map((part) => part.toString(16).padStart(2, "0")).join("")}`;
}
