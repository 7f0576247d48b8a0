// Wires the live page, and sends old replay links on to the replay page.

import { BoardView } from "../board/view.js";
import { Histogram } from "../instruments/histogram.js";
import { Session } from "../model/player/session.js";
import { messageOf } from "../net/api.js";
import { Theme } from "../paint/theme.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { keepOffline } from "../util/offline.js";
import { Wallet } from "./account/wallet.js";
import { showRecall } from "./account/recall.js";
import { keepFields } from "./input/kept-fields.js";
import { chooseLanguage } from "./input/language.js";
import { Ghost } from "./show/ghost.js";
import { TablePage } from "./page.js";
import { leadBack } from "./rooms.js";

async function start() {
  const asked = new URLSearchParams(window.location.search);
  if (asked.has("board") && asked.has("seed")) {
    window.location.replace(`replay.html?${asked}`);
    return;
  }
  keepOffline();
  // Without WebAssembly the table sends paths, and nothing is computed here.
  const solving = openSolver().catch(() => null);
  const theme = await Theme.load();
  const histogram = new Histogram(byId("histogram", HTMLCanvasElement), theme);
  const canvases = {
    still: byId("board-still", HTMLCanvasElement),
    moving: byId("board-moving", HTMLCanvasElement),
  };
  const ghost = new Ghost(byId("board-ghost", HTMLCanvasElement), theme);
  const view = new BoardView(canvases, theme, (geometry) => {
    histogram.layOut(geometry);
    ghost.layOut(geometry);
  });
  chooseLanguage();
  keepFields(window.localStorage);
  const session = new Session(window.localStorage);
  const wallet = new Wallet(window.localStorage);
  showRecall(wallet.mark);
  await leadBack(session);
  const parts = { theme, view, histogram, ghost, session, wallet, solver: await solving };
  new TablePage(parts, asked);
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("state-text").textContent = t("page.failed");
  byId("result").textContent = messageOf(error);
  throw error;
});
