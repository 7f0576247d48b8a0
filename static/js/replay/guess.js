// The guessing game of shared links: the player guesses the bin while the page hides where the ball lands.

import { t } from "../texts/text.js";
import { byId, check, chip, onSubmit, radiosOf } from "../util/dom.js";
import { multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */

/** The panel with the question. `watching` is called to begin the fall. */
export class Guess {
  /** @param {Board} board @param {() => void} watching */
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

  /** Chooses the bin at a place on the board, instead of in the list. @param {{x: number, y: number}} place m */
  point({ x, y }) {
    const { edges } = this.bins;
    const bin = edges.findIndex((edge, i) => y > this.bins.y && x >= edge && x < edges[i + 1]);
    if (bin >= 0) check("guess", bin);
  }

  /** Ends the game after the landing. @returns {number | null} the guessed bin */
  tell() {
    this.open = false;
    this.panel.hidden = true;
    document.documentElement.dataset.told = "yes";
    const chosen = radiosOf("guess").find(({ checked }) => checked);
    return chosen ? Number(chosen.value) : null;
  }
}

/**
 * @param {number | null} guess the guessed bin, if any
 * @param {number | null} bin null if the ball did not land
 * @returns {string} a sentence about the guess
 */
export function guessWords(guess, bin) {
  if (guess === null || bin === null) return "";
  const off = Math.abs(guess - bin);
  return off === 0 ? ` ${t("replay.right")}` : ` ${t("replay.wrong", { n: off, guess })}`;
}
