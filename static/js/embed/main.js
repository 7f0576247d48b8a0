// A drop that another site shows in a frame: guess where it lands, let it fall, see.

import { DEFAULT_BOARD, DEFAULT_SEED, openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { replayLink, readDrop } from "../net/drop-address.js";
import { paintPath } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { boardOf, Replay } from "../replay/replay.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { FrameLoop } from "../util/frame-loop.js";

/** @import { Layer } from "../board/stage.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */

class EmbeddedDrop {
  /** @type {Replay | null} */
  #replay = null;
  #t = 0;
  #lastMs = 0;
  #falling = false;

  /** @param {Theme} theme */
  constructor(theme) {
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.stage = new Stage(theme, () => this.loop.wake());
    this.button = byId("drop", HTMLButtonElement);
    this.button.addEventListener("click", () => this.#fall());
  }

  /** @param {DropAddress} asked @param {string} hash */
  async open(asked, hash) {
    const { board, address } = await boardOf(asked.board || DEFAULT_BOARD, hash);
    const drop = { ...asked, board: address, seed: asked.seed || DEFAULT_SEED };
    const replay = await Replay.compute(board, drop);
    this.#replay = replay;
    this.stage.setBoard(board);
    byId("more", HTMLAnchorElement).href = hash ? `replay.html?seed=${drop.seed}${hash}` : replayLink(drop);
    document.title = t("replay.title-seed", { seed: drop.seed, board: board.name });
    showState("replay", t("play.ready"));
    byId("result").textContent = t("embed.guess");
    this.button.disabled = false;
    this.loop.wake();
  }

  #fall() {
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.#t = calm ? (this.#replay?.end ?? 0) : 0;
    this.#lastMs = 0;
    this.#falling = true;
    this.button.disabled = true;
    byId("result").textContent = t("embed.falling");
    this.loop.wake();
  }

  /** @param {number} now ms */
  #draw(now) {
    const replay = this.#replay;
    if (!replay) return false;
    if (this.#falling) {
      this.#t += this.#lastMs ? (now - this.#lastMs) / 1000 : 0;
      this.#lastMs = now;
      if (this.#t >= replay.duration) this.#tell(replay);
    }
    this.stage.draw(replay.sceneAt(this.#t), (layer) => this.#paintPath(layer, replay));
    if (this.#t >= replay.end) this.#falling = false;
    return this.#falling;
  }

  /** @param {Replay} replay whose ball is down */
  #tell({ board, record: { bin, score } }) {
    const text = bin === null ? t("embed.none") : t("embed.pays", { bin, pays: prizeOf(board, bin, score) });
    const result = byId("result");
    if (result.textContent !== text) result.textContent = text;
    this.button.disabled = false;
    this.button.textContent = t("embed.again");
  }

  /** What it has fallen so far; what is to come stays untold. @param {Layer} layer @param {Replay} replay */
  #paintPath({ ctx, geometry }, replay) {
    const width = Math.max(1.5, 0.2 * replay.board.ball.radius * geometry.scale);
    paintPath(ctx, geometry, replay.pathTo(this.#t), { colour: this.theme.palette.trayMark, width, alpha: 0.8 });
  }
}

openPage((theme) => {
  const search = new URLSearchParams(window.location.search);
  return new EmbeddedDrop(theme).open(readDrop(search), window.location.hash);
});
