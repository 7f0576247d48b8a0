// Guess where it lands: while the ball of a shared link falls, the page keeps to itself where to.

import { t } from "../texts/text.js";
import { byId, check, chip, onSubmit, radiosOf } from "../util/dom.js";
import { multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */

const DAY_BOARD = "triangle-16";

/** The panel that asks. `watching` begins the fall; what would tell its end is hidden until then. */
export class Guess {
  /** @param {Board} board whose bins are to be chosen from @param {() => void} watching */
  constructor({ bins }, watching) {
    this.bins = bins;
    this.panel = byId("guess");
    this.open = false;
    onSubmit("guess", () => {
      this.panel.hidden = true;
      watching();
    });
  }

  ask() {
    this.open = true;
    document.documentElement.dataset.told = "no";
    byId("guess-bins").replaceChildren(...this.bins.multipliers.map((score, bin) => {
      const pays = multiplier(score);
      return chip("guess", String(bin), pays, t("replay.guess-bin", { bin, pays }));
    }));
    this.panel.hidden = false;
    byId("result").textContent = t("replay.where");
  }

  /** A bin of the board is as good as its name in the list. @param {{x: number, y: number}} place m */
  point({ x, y }) {
    const { edges } = this.bins;
    const bin = edges.findIndex((edge, i) => y > this.bins.y && x >= edge && x < edges[i + 1]);
    if (bin >= 0) check("guess", bin);
  }

  /** The ball is down: nothing is kept back any more. @returns {number | null} what was guessed */
  tell() {
    this.open = false;
    this.panel.hidden = true;
    document.documentElement.dataset.told = "yes";
    const chosen = radiosOf("guess").find(({ checked }) => checked);
    return chosen ? Number(chosen.value) : null;
  }
}

/**
 * The drop of the day: one for everybody, named by the day in Greenwich.
 * @param {Date} now
 * @returns {{board: string, seed: string}}
 */
export function dropOfDay(now) {
  return { board: DAY_BOARD, seed: now.toISOString().slice(0, 10).replaceAll("-", "") };
}

/**
 * @param {number | null} guess the bin that a player named, if any
 * @param {number | null} bin where the ball landed; null: in none
 * @returns {string} what the player hears
 */
export function guessWords(guess, bin) {
  if (guess === null || bin === null) return "";
  const off = Math.abs(guess - bin);
  return off === 0 ? ` ${t("replay.right")}` : ` ${t("replay.wrong", { n: off, guess })}`;
}
