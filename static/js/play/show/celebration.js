// Celebrates a win: confetti from its bin from 5 times the stake, a full scene from 100 times.

import { binBox } from "../../paint/board.js";
import { messageOf } from "../../net/api.js";
import { replayLink } from "../../net/drop-address.js";
import { saveVideo } from "../../net/video.js";
import { t } from "../../texts/text.js";
import { fitted } from "../../util/canvas.js";
import { byId, onClick } from "../../util/dom.js";
import { amount, multiplier } from "../../util/format.js";

/** @import { BoardView } from "../../board/view.js" */
/** @import { Played } from "../../model/player/account.js" */
/** @import { Theme } from "../../paint/theme.js" */

export const WIN = 5; // times the stake: celebrated with a banner and confetti
export const JACKPOT = 100; // times the stake: celebrated with a full scene
const COUNT_MS = 1800;
const BANNER_MS = 1600;
const CARD_MS = 6000;
const GRAVITY = 900; // px/s²
const DRAG = 1.1; // 1/s
const LIFE_S = 2.2;
const MOST = 420; // pieces at once
const SHELLS = 6; // further bursts of a scene, SHELL_S apart
const SHELL_S = 0.55;

/**
 * A piece of confetti, and a planned burst of many.
 * @typedef {{x: number, y: number, vx: number, vy: number, spin: number, born: number, colour: string,
 *   size: number}} Piece
 * @typedef {{at: number, x: number, y: number, count: number}} Shell
 */

/** Confetti, the banner of a win, and the card of a jackpot. */
export class Celebration {
  /** The card that counts up. @type {{score: number, since: number | null} | null} */
  #card = null;
  /** @type {Piece[]} */
  #pieces = [];
  /** @type {Shell[]} */
  #shells = [];
  #last = 0;
  #closing = 0; // the timer that closes the card
  /** The card's drop. @type {Played | null} */
  #won = null;

  /** @param {Theme} theme @param {BoardView} view */
  constructor(theme, view) {
    this.theme = theme;
    this.view = view;
    this.canvas = byId("board-party", HTMLCanvasElement);
    onClick("card-close", () => this.hide());
    onClick("card-video", () => this.#saveVideo());
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || byId("card").hidden) return;
      event.stopPropagation(); // Escape closes one thing at a time
      this.hide();
    }, { capture: true });
  }

  hide() {
    window.clearTimeout(this.#closing);
    this.#card = null;
    byId("card").hidden = true;
    delete byId("card").dataset.scene;
  }

  /** @param {Played} played a win of at least WIN times the stake @param {boolean} still whether motion is reduced */
  celebrate(played, still) {
    const { geometry, board } = this.view;
    const { score, bin } = played;
    if (score >= JACKPOT) this.#showCard(played, still);
    else this.#showBanner(played, still);
    if (still || !geometry || !board || bin === null) return;
    const box = binBox(geometry, board, bin);
    const now = performance.now() / 1000;
    const count = Math.min(180, 30 + 8 * score);
    this.#shells.push({ at: now, x: box.x + box.width / 2, y: box.y, count });
    for (let i = 1; i <= (score < JACKPOT ? 0 : SHELLS); i += 1) {
      const x = geometry.width * (0.15 + 0.7 * Math.random());
      const y = geometry.height * (0.15 + 0.35 * Math.random());
      this.#shells.push({ at: now + i * SHELL_S, x, y, count: 70 });
    }
  }

  /** @param {Played} played @param {boolean} still */
  #showBanner({ score, paid, practice }, still) {
    const banner = byId("banner");
    banner.textContent = practice ? multiplier(score) : `${multiplier(score)}  ${amount(paid)}`;
    banner.hidden = false;
    const { fill, ink } = this.theme.payout(score);
    Object.assign(banner.style, { background: fill, color: ink });
    const gone = () => { banner.hidden = true; };
    if (still) {
      window.setTimeout(gone, BANNER_MS);
      return;
    }
    for (const old of banner.getAnimations()) old.cancel();
    const [small, large] = ["translate(-50%, 40%) scale(0.3)", "translate(-50%, 0) scale(1)"];
    banner.animate(
      [
        { transform: small, opacity: 0 }, { transform: "translate(-50%, 0) scale(1.15)", opacity: 1, offset: 0.14 },
        { transform: large, opacity: 1, offset: 0.22 }, { transform: large, opacity: 1, offset: 0.8 },
        { transform: "translate(-50%, -30%) scale(0.96)", opacity: 0 },
      ],
      { duration: BANNER_MS, easing: "ease-out" },
    ).onfinish = gone;
  }

  /** @param {Played} played @param {boolean} still */
  #showCard(played, still) {
    const { score, stake, paid, practice, by = "", knocked = false } = played;
    this.#won = played;
    byId("card-video").hidden = byId("card-share").hidden = knocked; // such a ball cannot be replayed alone
    byId("card-name").textContent = by;
    byId("card-words").textContent = practice
      ? t("play.win-practice")
      : t("play.win-paid", { paid: amount(paid), stake: amount(stake) });
    byId("card-share", HTMLAnchorElement).href = replayLink(played);
    byId("card").hidden = false;
    byId("card").dataset.scene = String(!still);
    byId("card-score").textContent = multiplier(still ? score : 0);
    this.#card = still ? null : { score, since: null };
    window.clearTimeout(this.#closing);
    this.#closing = window.setTimeout(() => this.hide(), CARD_MS);
  }

  async #saveVideo() {
    const [button, words] = [byId("card-video", HTMLButtonElement), byId("card-words")];
    if (!this.#won) return;
    window.clearTimeout(this.#closing);
    button.disabled = true;
    words.textContent = t("page.computing");
    try {
      await saveVideo(this.#won);
      this.hide();
    } catch (error) {
      words.textContent = messageOf(error);
    }
    button.disabled = false;
  }

  /** @param {number} nowMs @returns {boolean} whether it still moves */
  show(nowMs) {
    this.#count(nowMs);
    this.#fly(nowMs / 1000);
    return this.#card !== null || this.#shells.length > 0 || this.#pieces.length > 0;
  }

  /** @param {number} nowMs */
  #count(nowMs) {
    const card = this.#card;
    if (!card) return;
    card.since ??= nowMs;
    const part = Math.min(1, (nowMs - card.since) / COUNT_MS);
    const shown = part === 1 ? card.score : Math.floor(card.score * (1 - (1 - part) ** 3));
    byId("card-score").textContent = multiplier(shown);
    if (part === 1) this.#card = null;
  }

  /** @param {number} now s */
  #fly(now) {
    for (const shell of this.#shells.filter(({ at }) => at <= now)) this.#burst(shell, now);
    this.#shells = this.#shells.filter(({ at }) => at > now);
    const step = Math.min(0.05, now - this.#last);
    this.#last = now;
    this.#pieces = this.#pieces.filter(({ born }) => now - born < LIFE_S);
    this.canvas.hidden = this.#pieces.length === 0;
    if (!this.canvas.hidden) this.#paint(now, step);
  }

  /** @param {Shell} shell @param {number} now */
  #burst({ x, y, count }, now) {
    const { palette } = this.theme;
    const colours = [palette.ball, palette.flash, palette.trayBar, palette.rail, ...[2, 5, 10, 40].map((score) =>
      this.theme.payout(score).fill)];
    for (let i = 0; i < count && this.#pieces.length < MOST; i += 1) {
      const angle = -Math.PI / 2 + (Math.random() - 0.5) * 2.2;
      const speed = 180 + 520 * Math.random();
      this.#pieces.push({
        x, y, vx: speed * Math.cos(angle), vy: speed * Math.sin(angle), spin: 14 * (Math.random() - 0.5), born: now,
        colour: colours[i % colours.length], size: 3 + 5 * Math.random(),
      });
    }
  }

  /** @param {number} now s @param {number} step s */
  #paint(now, step) {
    const { geometry } = this.view;
    if (!geometry) return;
    const ctx = fitted(this.canvas, geometry);
    for (const piece of this.#pieces) {
      const slower = Math.exp(-DRAG * step);
      piece.vx *= slower;
      piece.vy = piece.vy * slower + GRAVITY * step;
      piece.x += piece.vx * step;
      piece.y += piece.vy * step;
      const age = (now - piece.born) / LIFE_S;
      ctx.globalAlpha = Math.min(1, 3 * (1 - age));
      ctx.fillStyle = piece.colour;
      // A turning strip of paper, seen from the side.
      const wide = piece.size * Math.abs(Math.cos(piece.spin * (now - piece.born)));
      ctx.fillRect(piece.x - wide / 2, piece.y - piece.size, wide, 2 * piece.size);
    }
    ctx.globalAlpha = 1;
  }
}
