// The live page: the game, and the panels that show it. Old replay links are sent on to the replay page.

import { messageOf } from "../net/api.js";
import { streamsFor } from "../net/streams.js";
import { Theme } from "../paint/theme.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { keepOffline } from "../util/offline.js";
import { Visited } from "../model/player/visited.js";
import { Aim } from "./desk/aim.js";
import { Desk } from "./desk/desk.js";
import { Drawers } from "./desk/drawers.js";
import { TableForm } from "./desk/table-form.js";
import { Game } from "./game.js";
import { CompanyPanel } from "./panels/company.js";
import { DrawPanel } from "./panels/draw.js";
import { FairPanel } from "./panels/fairness.js";
import { HandOn } from "./panels/hand-on.js";
import { History } from "./panels/history.js";
import { OddsNote } from "./panels/odds.js";
import { Purse } from "./panels/purse.js";
import { offerSettings } from "./panels/settings.js";
import { Statistics } from "./panels/statistics.js";
import { TryMoon, Worlds } from "./panels/worlds.js";
import { leadBack, roomOfAddress } from "./rooms.js";
import { Picture } from "./show/picture.js";

async function start() {
  const asked = new URLSearchParams(window.location.search);
  if (asked.has("board") && asked.has("seed")) {
    window.location.replace(`replay.html?${asked}`);
    return;
  }
  keepOffline();
  const storage = window.localStorage;
  // Without WebAssembly the table sends paths, and nothing is computed here.
  const opening = openSolver().catch(() => null);
  const theme = await Theme.load();
  await leadBack(new Visited(storage));
  const solver = await opening;
  const streams = streamsFor(asked.get("stream"), solver !== null);
  const game = new Game({ storage, solver, streams, room: roomOfAddress() });
  window.addEventListener("popstate", () => game.enter(roomOfAddress()));
  const { view, ghost } = new Picture(game, theme);
  for (const Panel of [
    Desk, Aim, TableForm, Drawers, History, Statistics, FairPanel, DrawPanel, CompanyPanel, HandOn, OddsNote,
    TryMoon,
  ]) new Panel(game, theme);
  for (const box of ["worlds", "places"]) new Worlds(game, theme, box);
  new Purse(game, theme, view);
  offerSettings(game, theme, ghost);
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("state-text").textContent = t("page.failed");
  byId("result").textContent = messageOf(error);
  throw error;
});
