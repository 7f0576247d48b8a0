// The page as a replay: loads the drop that the address names and plays it on the board.

import { byId } from "./dom.js";
import { multiplier } from "./format.js";
import { FrameLoop } from "./frame-loop.js";
import { announceShape } from "./geometry.js";
import { MAIN_ROOM, readBoardName } from "./boards.js";
import { Replay } from "./replay.js";
import { ReplayDesk } from "./replay-desk.js";
import { Scoreboard } from "./scoreboard.js";
import { describeBoard } from "./words.js";

/** @param {import("./main.js").Parts} parts @param {URLSearchParams} asked */
export async function startReplay({ theme, view, session }, asked) {
  const drop = { board: asked.get("board"), seed: asked.get("seed"), x: asked.get("x") };
  new Scoreboard(session, theme, (seed) => window.location.assign(backTo(session, drop, seed)));
  showReplayDesk(session, drop);
  const replay = await Replay.load(drop);
  const { board, record } = replay;
  announceShape(board);
  view.setBoard(board, board.drop.slots ?? []);
  byId("board-moving").setAttribute("aria-label", describeBoard(board));

  const loop = new FrameLoop((now) => {
    view.draw(replay.sceneAt(desk.advance(now)));
    return desk.playing;
  });
  const desk = new ReplayDesk(replay, () => loop.wake());
  const redraw = () => {
    view.repaint();
    loop.wake();
  };
  theme.onChange(redraw);
  view.onLayout = redraw;
  document.documentElement.dataset.state = "replay";
  document.documentElement.dataset.lastBin = record.bin === null ? "none" : String(record.bin);
  byId("replay-result").textContent = resultOf(record);
  byId("replay-result").style.setProperty("--paid", theme.payout(record.score).fill);
  if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) desk.seek(replay.end);
  else desk.play();
}

function showReplayDesk(session, drop) {
  document.documentElement.dataset.mode = "replay";
  byId("drop-form").hidden = true;
  byId("board-form").hidden = true;
  byId("replay").hidden = false;
  byId("history").hidden = session.last.length === 0;
  byId("state-text").textContent = "Replay";
  byId("replay-title").textContent = `Replay of seed ${drop.seed}`;
  byId("replay-back").href = backTo(session, drop);
  document.title = `Seed ${drop.seed} on ${drop.board} – Plinko`;
}

function resultOf({ bin, score, seed }) {
  if (bin === null) return `Seed ${seed} comes to rest in no bin; its stake goes back.`;
  return `Seed ${seed} lands in bin ${bin} and pays ${multiplier(score)}.`;
}

/** Back to where the visitor played, or else to this board's own table. */
function backTo(session, drop, seed) {
  const room = session.room || (readBoardName(drop.board) ? drop.board : MAIN_ROOM);
  const search = new URLSearchParams({ ...(room !== MAIN_ROOM && { room }), ...(seed && { seed }) });
  return search.size ? `?${search}` : "./";
}
