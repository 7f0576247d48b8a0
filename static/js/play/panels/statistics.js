// The statistics since the last reset: profit with its curve around zero, balls, wins, losses and the best multiplier.

import { t } from "../../texts/text.js";
import { byId, onClick } from "../../util/dom.js";
import { amount, multiplier, plain, signed } from "../../util/format.js";

/** @import { Game } from "../game.js" */

const RENEWED_MS = 200; // between two updates while many balls land
const [WIDE, HIGH] = [240, 64]; // the view box of the curve's SVG

/** @param {Game} game */
export function showStatistics(game) {
  const [area, line, mark] = ["curve-area", "curve-line", "curve-mark"].map((id) => document.getElementById(id));
  const curve = byId("curve");
  /** Where the pointer is on the curve, 0 … 1; null if it is elsewhere. @type {number | null} */
  let at = null;

  const show = () => {
    const { staked, returned, profit, balls, wins, losses, best } = game.account;
    /** @type {[string, string][]} */
    const values = [
      ["staked", amount(staked)], ["returned", amount(returned)], ["balls", plain(balls)], ["wins", plain(wins)],
      ["losses", plain(losses)], ["best", balls ? multiplier(best) : "–"],
    ];
    for (const [id, text] of values) byId(id).textContent = text;
    curve.setAttribute("aria-label", t("stats.curve", { profit: signed(profit), n: balls }));
    draw();
    point();
  };
  const draw = () => {
    const profits = game.account.curve;
    const most = Math.max(0.01, ...profits.map(Math.abs));
    const places = profits.map((value, i) => {
      const [x, y] = [(WIDE * i) / (profits.length - 1), (HIGH / 2) * (1 - (0.94 * value) / most)];
      return `${x.toFixed(1)},${y.toFixed(1)}`;
    }).join(" ");
    line?.setAttribute("points", places);
    area?.setAttribute("points", `0,${HIGH / 2} ${places} ${WIDE},${HIGH / 2}`);
  };
  /** Shows the profit at the pointer, else the present one. */
  const point = () => {
    const { curve: profits, every, balls } = game.account;
    const i = Math.round((at ?? 1) * (profits.length - 1));
    byId("net").textContent = signed(profits[i]);
    byId("net").dataset.sign = String(Math.sign(Math.round(profits[i] * 100)));
    byId("net-of").textContent = at === null ? t("stats.profit") : t("stats.after", { n: Math.min(i * every, balls) });
    const x = String((WIDE * i) / (profits.length - 1));
    for (const end of ["x1", "x2"]) mark?.setAttribute(end, x);
    mark?.toggleAttribute("hidden", at === null);
  };
  for (const kind of /** @type {const} */ (["pointermove", "pointerdown", "pointerleave", "pointercancel"])) {
    curve.addEventListener(kind, ({ clientX }) => {
      const { left, width } = curve.getBoundingClientRect();
      const inside = kind === "pointermove" || kind === "pointerdown";
      at = inside ? Math.max(0, Math.min(1, (clientX - left) / width)) : null;
      point();
    });
  }
  onClick("stats-reset", () => game.reset());
  game.onCalm("account", RENEWED_MS, show);
  show();
}
