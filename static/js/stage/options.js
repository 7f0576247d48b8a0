// Reads the stage's options from its address. Pure.

import { MAIN_ROOM } from "../model/presets.js";

/** @typedef {"best" | "balls" | "prizes"} Rank what players are ranked by */
/** @typedef {"pile" | "bars"} TrayKind how landed balls are shown */
/** @typedef {"on" | "binomial"} Theory expected counts: of this board, or of an ideal Galton board */

/**
 * @typedef {object} StageOptions
 * @property {string} room
 * @property {string | null} ground the page's background: null for the theme's, "transparent", or #rrggbb
 * @property {boolean} plate whether the board has its own background
 * @property {boolean} names whether balls show their players' names
 * @property {boolean} winners whether the last landings are listed
 * @property {Rank | null} leaders null for no leaderboard
 * @property {boolean} queue whether the queue is shown
 * @property {boolean} join whether a QR code leads phones to the room
 * @property {TrayKind | null} tray null for no tray
 * @property {Theory | null} expected null for no comparison
 * @property {boolean} sound
 */

/** @type {Rank[]} */
const RANKS = ["best", "balls", "prizes"];
/** @type {TrayKind[]} */
const TRAYS = ["pile", "bars"];
/** @type {Theory[]} */
const THEORIES = ["on", "binomial"];
const COLOUR = /^#?([0-9a-f]{6})$/i;

/** @param {URLSearchParams} asked @returns {StageOptions} invalid options have their defaults */
export function readOptions(asked) {
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
