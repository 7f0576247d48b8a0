// Wires the page: decides between table and replay, and carries news from one part to another.

import { ApiError } from "./api.js";
import { BoardView } from "./board-view.js";
import { byId } from "./dom.js";
import { Histogram } from "./histogram.js";
import { Session } from "./session.js";
import { Theme } from "./theme.js";
import { startReplay } from "./page-replay.js";
import { startTable } from "./page-table.js";

/** @typedef {{theme: Theme, view: BoardView, histogram: Histogram, session: Session}} Parts */

async function start() {
  const theme = await Theme.load();
  const histogram = new Histogram(byId("histogram"), theme);
  const canvases = { still: byId("board-still"), moving: byId("board-moving") };
  const view = new BoardView(canvases, theme, (geometry) => histogram.layOut(geometry));
  const session = new Session(window.sessionStorage);
  const parts = { theme, view, histogram, session };
  const asked = new URLSearchParams(window.location.search);
  if (asked.has("board") && asked.has("seed")) await startReplay(parts, asked);
  else startTable(parts, asked);
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("state-text").textContent = "Failed";
  byId("result").textContent = error.message;
  byId("replay-result").textContent = error.message;
  // A refusal by the server is told to the visitor; anything else is a fault to be seen.
  if (!(error instanceof ApiError)) throw error;
});
