// Starts the stage page, for a projector or a stream: it shows one room, with the options in its address.

import { messageOf, streamsFor } from "../net/api.js";
import { Theme } from "../paint/theme.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";
import { Show } from "./show.js";
import { readOptions } from "./options.js";

/** @type {Record<import("./options.js").Rank, import("../texts/text.js").Key>} */
const TITLES = { best: "stage.best", balls: "stage.balls", prizes: "stage.prizes" };

async function start() {
  const asked = new URLSearchParams(window.location.search);
  const options = readOptions(asked);
  const { dataset, style } = document.documentElement;
  if (options.ground !== null) {
    dataset.key = "";
    style.setProperty("--key", options.ground);
  }
  if (options.leaders) byId("leaders-title").textContent = t(TITLES[options.leaders]);
  const solver = await openSolver().catch(() => null);
  new Show(options, { theme: new Theme(), solver, streams: streamsFor(asked.get("stream"), solver !== null) });
}

start().catch((error) => {
  document.documentElement.dataset.state = "failed";
  byId("result").textContent = messageOf(error);
  throw error;
});
