// What a stage's address asks to be shown. Pure.

import { MAIN_ROOM } from "../model/presets.js";

/** @typedef {"best" | "balls" | "prizes"} Rank what players are ranked by */
/** @typedef {"pile" | "bars"} TrayKind how what has landed lies below the board */
/** @typedef {"on" | "binomial"} Theory what it is compared with: this board's odds, or those of an ideal one */

/**
 * @typedef {object} Wishes
 * @property {string} room
 * @property {string | null} ground what lies around the board: null for the page's own, "transparent", or #rrggbb
 * @property {boolean} plate whether the board has its own ground
 * @property {boolean} names whether names are shown at the balls
 * @property {boolean} winners whether the last landings are listed
 * @property {Rank | null} leaders null for no leaderboard
 * @property {boolean} queue whether it is told what waits
 * @property {boolean} join whether phones are shown the way to the room
 * @property {TrayKind | null} tray null for none
 * @property {Theory | null} expected null where it is compared with nothing
 * @property {boolean} sound
 */

/** @type {Rank[]} */
const RANKS = ["best", "balls", "prizes"];
/** @type {TrayKind[]} */
const TRAYS = ["pile", "bars"];
/** @type {Theory[]} */
const THEORIES = ["on", "binomial"];
const COLOUR = /^#?([0-9a-f]{6})$/i;

/** @param {URLSearchParams} asked @returns {Wishes} what cannot be read is as if it were not asked */
export function readWishes(asked) {
  const leaders = asked.get("leaders");
  return {
    room: asked.get("room") || MAIN_ROOM,
    ground: groundOf(asked.get("ground")),
    plate: asked.get("plate") !== "off",
    names: asked.get("names") !== "off",
    winners: asked.get("winners") !== "off",
    leaders: leaders === "off" ? null : oneOf(RANKS, leaders) ?? "best",
    queue: asked.get("queue") !== "off",
    join: asked.get("join") === "on",
    tray: oneOf(TRAYS, asked.get("tray")),
    expected: oneOf(THEORIES, asked.get("expected")),
    sound: asked.get("sound") === "on",
  };
}

/**
 * @template {string} T
 * @param {T[]} known @param {string | null} text
 * @returns {T | null}
 */
function oneOf(known, text) {
  return known.find((one) => one === text) ?? null;
}

/** @param {string | null} text */
function groundOf(text) {
  if (text === "transparent") return text;
  const found = COLOUR.exec(text ?? "");
  return found ? `#${found[1].toLowerCase()}` : null;
}
