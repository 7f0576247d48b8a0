// Starts the live page: the game and its panels. Old replay links are redirected to the replay page.

import { messageOf, streamsFor } from "../net/api.js";
import { Theme } from "../paint/theme.js";
import { openSolver } from "../solver/solver.js";
import { number, t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { painted } from "../util/frame-loop.js";
import { keepOffline } from "../util/offline.js";
import { local } from "../util/storage.js";
import { Visited } from "../model/player/visited.js";
import { Aim } from "./desk/aim.js";
import { Desk } from "./desk/desk.js";
import { offerDrawers } from "./desk/drawers.js";
import { offerTables } from "./desk/table-form.js";
import { Game } from "./game.js";
import { loadLater } from "./later.js";
import { offerLink } from "./panels/hand-on.js";
import { showOdds } from "./panels/odds.js";
import { showBalance } from "./panels/balance.js";
import { showPadlock } from "./panels/padlock.js";
import { offerWorlds } from "./panels/worlds.js";
import { leadBack, roomOfAddress } from "./rooms.js";
import { BoardScreen } from "./show/board-screen.js";

async function start() {
  const asked = new URLSearchParams(window.location.search);
  if (asked.has("board") && asked.has("seed")) {
    window.location.replace(`replay.html?${asked}`);
    return;
  }
  keepOffline();
  await painted();
  // Without WebAssembly the server sends snapshots, and the page computes nothing.
  const opening = openSolver().catch(() => null);
  number(0); // loads how the language writes numbers, which takes long
  const theme = new Theme();
  await leadBack(new Visited(local));
  const solver = await opening;
  const streams = streamsFor(asked.get("stream"), solver !== null);
  const game = new Game({ storage: local, solver, streams, room: roomOfAddress() });
  window.addEventListener("popstate", () => game.enter(roomOfAddress()));
  const screen = new BoardScreen(game, theme);
  new Desk(game);
  new Aim(game);
  for (const panel of [offerTables, showPadlock, offerLink, showOdds, offerWorlds]) panel(game, theme);
  showBalance(game, theme, screen.view);
  offerDrawers(game, loadLater(game, theme, screen));
  game.begin();
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("state-text").textContent = t("page.failed");
  byId("result").textContent = messageOf(error);
  throw error;
});
