// A lesson: the settings of its boards, what is shown, and which balls have fallen; as the text of a link. Pure.

import { P, RESTITUTION, ROWS } from "./board.js";

/** @import { Setting } from "./board.js" */

/**
 * @typedef {"bins" | "rows" | "runs" | "average" | "means"} View
 * @typedef {{seed: number, drops: number}} Run consecutive seeds
 *
 * @typedef {object} Lesson
 * @property {Setting} setting
 * @property {string} change of the second board, such as "restitution:0.6"; empty without a second board
 * @property {View} view
 * @property {number} size of a sample
 * @property {number[] | null} guess heights, 0 … 100, one for each bin; null without a guess
 * @property {Run[]} runs
 */

export const EARTH = 9.81; // m/s²
/** @type {View[]} */
export const VIEWS = ["bins", "rows", "runs", "average", "means"];
const GUESSED = 100; // the greatest height
export const MOST = 2000; // balls that a link drops again

/** @param {Setting} setting @param {string} change @returns {Setting | null} of the second board */
export function changed(setting, change) {
  const [name, value] = change.split(":");
  return value ? checked({ ...setting, [name]: Number(value) }) : null;
}

/** @param {Setting} setting @returns {Setting} with every value in its range */
function checked({ rows, p, restitution, gravity }) {
  return {
    rows: Math.round(within(rows, ROWS, 12)), p: within(p, P, 0.5),
    restitution: within(restitution, { least: 0.5, most: 0.9 }, RESTITUTION),
    gravity: within(gravity, { least: 1, most: 30 }, EARTH),
  };
}

/** @param {number} value @param {{least: number, most: number}} range @param {number} usual */
function within(value, { least, most }, usual) {
  return Number.isFinite(value) ? Math.min(most, Math.max(least, value)) : usual;
}

/** @param {string} hash of the address @returns {Lesson} invalid parts have their defaults */
export function readLesson(hash) {
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const numberOf = (/** @type {string} */ name) => Number.parseFloat(asked.get(name) ?? "");
  const setting = checked({
    rows: numberOf("rows"), p: numberOf("p"), restitution: numberOf("restitution"), gravity: numberOf("gravity"),
  });
  const guess = (asked.get("guess") ?? "").split(",").map(Number);
  const change = asked.get("change") ?? "";
  return {
    setting,
    change: /^(?:p|restitution|gravity):[\d.]+$/.test(change) ? change : "",
    view: VIEWS.find((view) => view === asked.get("view")) ?? "bins",
    size: Math.round(within(numberOf("size"), { least: 2, most: 100 }, 10)),
    guess: guess.length === setting.rows + 1 && guess.every((each) => each >= 0 && each <= GUESSED) ? guess : null,
    runs: runsOf(asked.get("runs") ?? ""),
  };
}

/** @param {string} text @returns {Run[]} */
function runsOf(text) {
  let left = MOST;
  return [...text.matchAll(/(\d{1,10})x(\d{1,6})/g)].map(([, seed, drops]) => {
    const run = { seed: Number(seed), drops: Math.min(left, Number(drops)) };
    left -= run.drops;
    return run;
  });
}

/** @param {Lesson} lesson @returns {string} for the address, with "#" */
export function writeLesson({ setting, change, view, size, guess, runs }) {
  const parts = { ...setting, ...(change && { change }), view, size, ...(guess && { guess: guess.join(",") }) };
  const dropped = runs.filter(({ drops }) => drops).map(({ seed, drops }) => `${seed}x${drops}`).join("_");
  const search = new URLSearchParams(Object.entries(parts).map(([name, value]) => [name, String(value)]));
  if (dropped) search.set("runs", dropped);
  return `#${search}`;
}
