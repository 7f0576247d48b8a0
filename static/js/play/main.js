// Wires the live page, and sends old replay links on to the replay page.

import { BoardView } from "../board/view.js";
import { byId } from "../util/dom.js";
import { Ghost } from "./ghost.js";
import { Histogram } from "../instruments/histogram.js";
import { Session } from "../model/session.js";
import { Theme } from "../paint/theme.js";
import { startTable } from "./page.js";

/** @typedef {{theme: Theme, view: BoardView, histogram: Histogram, ghost: Ghost,
 *   session: Session}} Parts */

async function start() {
  const asked = new URLSearchParams(window.location.search);
  if (asked.has("board") && asked.has("seed")) {
    window.location.replace(`replay.html?${asked}`);
    return;
  }
  const theme = await Theme.load();
  const histogram = new Histogram(byId("histogram"), theme);
  const canvases = { still: byId("board-still"), moving: byId("board-moving") };
  const ghost = new Ghost(byId("board-ghost"), theme);
  const view = new BoardView(canvases, theme, (geometry) => {
    histogram.layOut(geometry);
    ghost.layOut(geometry);
  });
  const session = new Session(window.sessionStorage);
  const parts = { theme, view, histogram, ghost, session };
  startTable(parts, asked);
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("state-text").textContent = "Failed";
  byId("result").textContent = error.message;
  throw error;
});
