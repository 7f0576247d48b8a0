// Guess where it lands: while the ball of a shared link falls, the page keeps to itself where to.

import { t } from "../texts/text.js";
import { byId, make, radiosOf } from "../util/dom.js";
import { multiplier } from "../util/format.js";

/** @import { Board } from "../model/board.js" */

/** The panel that asks. `watching` begins the fall; what would tell its end is hidden until then. */
export class Guess {
  /** @param {() => void} watching */
  constructor(watching) {
    this.panel = byId("guess", HTMLFormElement);
    this.open = false;
    this.panel.addEventListener("submit", (event) => {
      event.preventDefault();
      this.panel.hidden = true;
      watching();
    });
  }

  /** @param {Board} board whose bins are to be chosen from */
  ask({ bins }) {
    this.open = true;
    document.documentElement.dataset.told = "no";
    const chips = bins.multipliers.map((pays, bin) => make(
      "label", { class: "chip" },
      make("input", { type: "radio", name: "guess", value: String(bin), "aria-label": t("replay.guess-bin", { bin, pays: multiplier(pays) }) }),
      make("span", {}, multiplier(pays)),
    ));
    byId("guess-bins").replaceChildren(...chips);
    this.panel.hidden = false;
    byId("result").textContent = t("replay.where");
  }

  /** A bin of the board is as good as its name in the list. @param {Board} board @param {{x: number, y: number}} place m */
  point({ bins: { y, edges } }, place) {
    const bin = edges.findIndex((edge, i) => place.y > y && place.x >= edge && place.x < edges[i + 1]);
    const radio = radiosOf("guess")[bin];
    if (radio) radio.checked = true;
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
