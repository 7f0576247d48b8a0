// The panels of the sheet. A page loads them when they are needed: see later.js.

import { hasServer } from "../../net/ask.js";
import { showVisitors } from "./visitors.js";
import { showBins } from "./bin-words.js";
import { showDraw } from "./draw.js";
import { showFairness } from "./fairness.js";
import { showHistory } from "./history.js";
import { offerSettings } from "./settings.js";
import { showStatistics } from "./statistics.js";

/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */
/** @import { Show } from "../show/show.js" */

/** @param {Game} game @param {Theme} theme @param {Show} show @param {boolean} touched whether there was a gesture */
export function fillSheet(game, theme, show, touched) {
  for (const panel of [showHistory, showStatistics, showFairness, showDraw, showBins]) panel(game, theme);
  if (hasServer) showVisitors(game, theme, touched);
  offerSettings(game, theme, show);
}
