// The balance in the page's header, and the wins that fly into it from the bins.

import { binBox } from "../../paint/board.js";
import { byId, make, onClick } from "../../util/dom.js";
import { amount } from "../../util/format.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const MOST = 8; // amounts flying at once; further wins only change the balance
const RISE_MS = 420;
const FLY_MS = 520;

/**
 * Shows the account's balance; each win flies from its bin to it.
 * @param {Game} game @param {Theme} theme @param {BoardView} view
 */
export function showBalance(game, theme, view) {
  const balance = byId("balance");
  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  let flying = 0;

  const show = () => {
    const text = amount(Math.max(0, game.account.balance));
    if (balance.textContent === text) return;
    balance.textContent = text;
    balance.style.setProperty("--letters", String(text.length));
  };

  /** @param {number} bin @param {number} paid credits @param {number} score */
  const fly = async (bin, paid, score) => {
    const { geometry, board } = view;
    if (!geometry || !board || still.matches || document.hidden || flying >= MOST) return;
    const stage = view.still.getBoundingClientRect();
    const box = binBox(geometry, board, bin);
    const from = { x: stage.left + box.x + box.width / 2, y: stage.top + box.y };
    const goal = balance.getBoundingClientRect();
    const to = { x: goal.left + goal.width / 2, y: goal.top + goal.height / 2 };
    const ticket = make("span", { class: "ticket", "aria-hidden": "true" }, amount(paid));
    const { fill, ink } = theme.payout(score);
    Object.assign(ticket.style, { background: fill, color: ink, left: `${from.x}px`, top: `${from.y}px` });
    document.body.append(ticket);
    flying += 1;
    const up = `translate(-50%, -3.2rem)`;
    await ticket.animate(
      [{ transform: "translate(-50%, 0) scale(0.5)", opacity: 0 }, { transform: up, opacity: 1 }],
      { duration: RISE_MS, easing: "cubic-bezier(0.2, 0.9, 0.3, 1.3)", fill: "forwards" },
    ).finished;
    const there = `translate(calc(${to.x - from.x}px - 50%), ${to.y - from.y}px) scale(0.6)`;
    await ticket.animate(
      [{ transform: up, opacity: 1 }, { transform: there, opacity: 0.9, offset: 0.9 }, { transform: there, opacity: 0 }],
      { duration: FLY_MS, easing: "cubic-bezier(0.6, 0, 0.8, 0.4)", fill: "forwards" },
    ).finished;
    ticket.remove();
    flying -= 1;
    balance.animate([{ transform: "scale(1.12)" }, { transform: "none" }], { duration: 260, easing: "ease-out" });
  };

  onClick("refill", () => game.refill());
  game.on("account", show);
  game.on("seen", ({ bin, paid, score, practice }) => {
    if (bin !== null && !practice && paid > 0) void fly(bin, paid, score);
  });
  show();
}
