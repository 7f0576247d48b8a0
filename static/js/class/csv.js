// All landed balls as a table for a spreadsheet. Pure.

/** @import { Trial } from "./trial.js" */

const COMMA = /,/; // a language with decimal commas separates columns by semicolons

/** @param {Trial[]} trials @param {string} language of the spreadsheet @returns {string} a line for each ball */
export function csvOf(trials, language) {
  const separator = COMMA.test((0.5).toLocaleString(language)) ? ";" : ",";
  const lines = [["board", "run", "ball", "seed", "right", "rows"]];
  trials.forEach(({ runs, setting: { rows } }, board) => runs.forEach(({ bins, seeds }, run) =>
    bins.forEach((bin, ball) => lines.push([board + 1, run + 1, ball + 1, seeds[ball] ?? "", bin, rows].map(String)))));
  return lines.map((line) => `${line.join(separator)}\r\n`).join("");
}
