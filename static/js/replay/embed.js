// A drop in a frame of another site: the player guesses where it lands, lets it fall, and sees.

import { showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { replayLink } from "../net/drop-address.js";
import { paintPath } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { FrameLoop } from "../util/frame-loop.js";

/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Replay } from "./replay.js" */

/** @param {Theme} theme @param {Replay} replay @param {DropAddress} drop */
export function embed(theme, replay, drop) {
  const { board, record: { bin, score }, duration, end } = replay;
  const [button, result] = [byId("drop", HTMLButtonElement), byId("result")];
  let [time, lastMs, falling] = [0, 0, false];

  const loop = new FrameLoop((now) => {
    if (falling) {
      time += lastMs ? (now - lastMs) / 1000 : 0;
      lastMs = now;
      if (time >= duration) tell();
    }
    stage.show(replay.sceneAt(time), ({ ctx, geometry }) => {
      // Only the path so far: the rest would give the result away.
      const width = Math.max(1.5, 0.2 * board.ball.radius * geometry.scale);
      paintPath(ctx, geometry, replay.pathTo(time), { colour: theme.palette.trayMark, width, alpha: 0.8 });
    });
    if (time >= end) falling = false;
    return falling;
  });
  const stage = new Stage(theme, () => loop.wake());
  /** Shows the result. */
  const tell = () => {
    const text = bin === null ? t("embed.none") : t("embed.pays", { bin, pays: prizeOf(board, bin, score) });
    if (result.textContent !== text) result.textContent = text;
    button.disabled = false;
    button.textContent = t("embed.again");
  };
  button.addEventListener("click", () => {
    const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    [time, lastMs, falling] = [calm ? end : 0, 0, true];
    button.disabled = true;
    result.textContent = t("embed.falling");
    loop.wake();
  });
  stage.setBoard(board);
  result.textContent = t("embed.guess");
  button.disabled = false;
  loop.wake();
  const { hash } = window.location;
  byId("more", HTMLAnchorElement).href = hash ? `replay.html?seed=${drop.seed}${hash}` : replayLink(drop);
  document.title = t("replay.title-seed", { seed: drop.seed, board: board.name });
  showState("replay", t("play.ready"));
}
