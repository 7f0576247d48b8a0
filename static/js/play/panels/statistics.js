// The statistics since the last reset: profit with its curve, balls, wins, losses and the best multiplier.

import { t } from "../../texts/text.js";
import { byId, onClick } from "../../util/dom.js";
import { amount, multiplier, plain, signed } from "../../util/format.js";

/** @import { Game } from "../game.js" */

const RENEWED_MS = 200; // between two updates while many balls land
const [WIDE, HIGH] = [240, 64]; // the view box of the curve's SVG

/** @param {Game} game */
export function showStatistics(game) {
  const [line, zero] = ["curve-line", "curve-zero"].map((id) => document.getElementById(id));
  const show = () => {
    const { staked, returned, profit, balls, wins, losses, best, curve } = game.account;
    /** @type {[string, string][]} */
    const values = [
      ["net", signed(profit)], ["staked", amount(staked)], ["returned", amount(returned)], ["balls", plain(balls)],
      ["wins", plain(wins)], ["losses", plain(losses)], ["best", balls ? multiplier(best) : "–"],
    ];
    for (const [id, text] of values) byId(id).textContent = text;
    byId("net").dataset.sign = String(Math.sign(Math.round(profit * 100)));
    const top = Math.max(0, ...curve);
    const span = Math.max(top - Math.min(0, ...curve), 1e-9);
    const y = (/** @type {number} */ value) => (2 + ((HIGH - 4) * (top - value)) / span).toFixed(1);
    const points = curve.map((value, i) => `${((WIDE * i) / Math.max(1, curve.length - 1)).toFixed(1)},${y(value)}`);
    line?.setAttribute("points", points.join(" "));
    for (const end of ["y1", "y2"]) zero?.setAttribute(end, y(0));
    byId("curve").setAttribute("aria-label", t("stats.curve", { profit: signed(profit), n: balls }));
  };
  onClick("stats-reset", () => game.reset());
  game.onCalm("account", RENEWED_MS, show);
  show();
}
