// Loads the parts that a first visit can do without until its first ball has landed: the sheet, and the Lab.

import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Game } from "./game.js" */
/** @import { BoardScreen } from "./show/board-screen.js" */

const GESTURES = ["pointermove", "pointerdown", "keydown", "focusin"];

/**
 * @param {Game} game @param {Theme} theme @param {BoardScreen} screen
 * @returns {(drawer: string) => Promise<boolean>} loads what a drawer needs. If that cannot be fetched, it tells the
 *   player, and returns false
 */
export function loadLater(game, theme, screen) {
  let asked = false; // whether the sheet was requested; false again if it could not be fetched
  let filled = false; // whether the sheet's buttons work
  let touched = false; // whether there was a gesture

  const loadSheet = async () => {
    asked = true;
    const [show, sheet] = await Promise.all([screen.loadShow(), import("./panels/sheet.js").catch(() => null)]);
    asked = show !== null && sheet !== null;
    if (show && sheet && !filled) {
      filled = true;
      sheet.fillSheet(game, theme, show, touched);
    }
    return filled;
  };
  const loadLab = async () => {
    const lab = await import("./panels/fit.js").catch(() => null);
    if (lab) screen.instruments ??= new lab.FitMeter(game);
    return lab !== null;
  };
  /** @param {string} drawer */
  const load = async (drawer) => {
    const loaded = await loadSheet() && (drawer !== "lab" || await loadLab());
    if (!loaded) game.say(t("play.part-fails"), { urgent: true });
    return loaded;
  };
  const needed = () => { if (!asked) void load("game"); };
  const inView = () => { if (!byId("sheet").hidden) needed(); };
  const touch = () => {
    touched = true;
    inView();
  };
  const listed = () => { if (game.account.last.length > 0) needed(); };

  // The list of the last drops stands next to the board, and on a wide screen the drawer "Game" too.
  game.on("seen", needed);
  game.on("account", listed); // drops that ended while the page was elsewhere
  game.on("table", ({ hello }) => { if (hello.draw) inView(); });
  game.on("visitors", () => { if (game.room.visitors.here > 1) inView(); });
  game.on("landed", inView); // of drops by the API and the queue, too
  for (const gesture of GESTURES) document.addEventListener(gesture, touch);
  byId("sheet-body").addEventListener("click", async ({ target }) => {
    if (filled || !(target instanceof HTMLButtonElement) || !target.closest(".panel")) return;
    if (await load("game")) target.click();
  });
  listed();
  return load;
}
