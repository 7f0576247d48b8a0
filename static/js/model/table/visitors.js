// The visitors of a table, the owners of its balls, and the last landings. Pure.

import { payoutOf } from "../payout.js";
import { colourOf } from "../player/colour.js";

/** @import { Landed, Presence, Tag, Visitor } from "../messages.js" */
/** @import { Ball } from "./table.js" */

const MOST_KNOWN = 200; // visitors remembered: balls may outlast their owners' visits
const MOST_LANDINGS = 8;

/**
 * @typedef {{visitor?: number} & Tag} Owner of a ball; name and colour are those of the drop's tag, if it has
 *   one, and otherwise the visitor's
 * @typedef {{mine: boolean, owner: Owner | null, drop: {seed: string, x: number | null, aim?: number},
 *   score: number, bin: number | null, paid: number | null}} Landing owner: at the time of the landing; null if unknown;
 *   paid: minor units, null without a stake
 */

/** The visitors of one table, from its presence events. */
export class Visitors {
  /** This page's visitor number. @type {number | null} */
  you = null;
  here = 0;
  /** From the last presence event. @type {Visitor[]} */
  present = [];
  /** @type {Landing[]} the latest first */
  landings = [];
  /** @type {Map<number, Visitor>} */
  #known = new Map();

  /** @param {() => void} onChange */
  constructor(onChange) {
    this.onChange = onChange;
  }

  /** Forgets all visitors: a new connection gives new numbers, and so does another table. */
  begin() {
    this.you = null;
    this.here = 0;
    this.present = [];
    this.#known.clear();
    this.onChange();
  }

  /** @param {Presence} event @param {Iterable<Ball>} [balls] in flight */
  hear({ you, here, visitors }, balls = []) {
    this.you = you ?? this.you;
    this.here = here;
    this.present = visitors;
    for (const visitor of visitors) {
      this.#known.delete(visitor.visitor);
      this.#known.set(visitor.visitor, visitor);
    }
    for (const number of this.#known.keys()) {
      if (this.#known.size <= MOST_KNOWN) break;
      this.#known.delete(number);
    }
    for (const ball of balls) this.dye(ball);
    this.onChange();
  }

  /** @param {Pick<Ball, "visitor" | "tag">} ball @returns {Owner | null} */
  ownerOf({ visitor, tag }) {
    if (visitor === undefined) return tag ?? null;
    return { ...(this.#known.get(visitor) ?? { visitor }), ...tag };
  }

  /**
   * Gives a ball its owner's name and colour. Balls of this page's player have a special colour, unless
   * the player chose one.
   * @param {Ball} ball
   */
  dye(ball) {
    const owner = this.ownerOf(ball);
    ball.by = owner?.name;
    if (ball.mine) ball.pose.colour = owner?.colour;
    else if (owner) ball.pose.colour = swatchOf(owner);
  }

  /** @param {Ball} ball @param {Pick<Landed, "bin" | "score">} outcome @returns {Landing} */
  landed(ball, { bin, score }) {
    const { seed, x, explicit, aim, staked } = ball;
    const mine = ball.mine || (ball.visitor !== undefined && ball.visitor === this.you); // of another tab
    const paid = staked === undefined ? null : payoutOf(staked, score);
    const landing = { mine, owner: this.ownerOf(ball), drop: { seed, x: explicit ? x : null, aim }, score, bin, paid };
    this.landings = [landing, ...this.landings].slice(0, MOST_LANDINGS);
    this.onChange();
    return landing;
  }
}

/** @param {Owner} owner @returns {string} #rrggbb, the same in every page */
export function swatchOf({ visitor, name, colour }) {
  return colour ?? colourOf(String(visitor ?? name));
}
