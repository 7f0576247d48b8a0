// The page that other sites embed in a frame: the player guesses where a drop lands, lets it fall, and sees.

import { openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { replayLink, readDrop } from "../net/drop-address.js";
import { paintPath } from "../paint/marks.js";
import { prizeOf } from "../paint/prizes.js";
import { dropOf, Replay } from "../replay/replay.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { FrameLoop } from "../util/frame-loop.js";

/** @import { Theme } from "../paint/theme.js" */

/** @param {Theme} theme @param {Replay} replay */
function show(theme, replay) {
  const { board, record: { bin, score }, duration, end } = replay;
  const [button, result] = [byId("drop", HTMLButtonElement), byId("result")];
  let [time, lastMs, falling] = [0, 0, false];

  const loop = new FrameLoop((now) => {
    if (falling) {
      time += lastMs ? (now - lastMs) / 1000 : 0;
      lastMs = now;
      if (time >= duration) tell();
    }
    stage.draw(replay.sceneAt(time), ({ ctx, geometry }) => {
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
}

openPage(async (theme) => {
  const { search, hash } = window.location;
  const { board, drop } = await dropOf(readDrop(new URLSearchParams(search)));
  show(theme, await Replay.compute(board, drop));
  byId("more", HTMLAnchorElement).href = hash ? `replay.html?seed=${drop.seed}${hash}` : replayLink(drop);
  document.title = t("replay.title-seed", { seed: drop.seed, board: board.name });
  showState("replay", t("play.ready"));
});
