// Loads the parts that a first visit can do without until its first ball has landed: the sheet, and the Lab.

import { t } from "../texts/text.js";
import { byId } from "../util/dom.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Game } from "./game.js" */
/** @import { BoardScreen } from "./show/board-screen.js" */

const GESTURES = ["pointermove", "pointerdown", "keydown", "focusin"];

/**
 * @param {Game} game @param {Theme} theme @param {BoardScreen} screen
 * @returns {(drawer: string) => Promise<void>} loads what a drawer needs; rejects if that cannot be fetched
 */
export function loadLater(game, theme, screen) {
  /** @type {Promise<void> | null} */
  let sheet = null;
  /** @type {Promise<void> | null} */
  let lab = null;
  let filled = false; // whether the sheet's buttons work
  let touched = false; // whether there was a gesture

  const loadSheet = async () => {
    const show = await screen.loadShow();
    const { fillSheet } = await import("./panels/sheet.js");
    fillSheet(game, theme, show, touched);
    filled = true;
  };
  const loadLab = async () => {
    const { InstrumentPanel } = await import("./panels/instruments.js");
    screen.instruments = new InstrumentPanel(game, theme);
  };
  /** @param {string} drawer */
  const load = async (drawer) => {
    try {
      await (sheet ??= loadSheet());
      if (drawer === "lab") await (lab ??= loadLab());
    } catch (error) {
      sheet = lab = null;
      game.say(t("play.part-fails"), { urgent: true });
      throw error;
    }
  };
  const needed = () => {
    if (!sheet) load("game").catch(() => {}); // `load` has told the player; the next event retries
  };
  const inView = () => { if (!byId("sheet").hidden) needed(); };
  const touch = () => {
    touched = true;
    inView();
  };
  const listed = () => { if (!sheet && game.account.last.length > 0) needed(); };

  // The list of the last drops stands next to the board, and on a wide screen the drawer "Game" too.
  game.on("seen", needed);
  game.on("account", listed); // drops that ended while the page was elsewhere
  game.on("table", ({ hello }) => { if (hello.draw) inView(); });
  game.on("visitors", () => { if (game.room.visitors.here > 1) inView(); });
  game.on("landed", inView); // of drops by the API and the queue, too
  for (const gesture of GESTURES) document.addEventListener(gesture, touch);
  byId("sheet-body").addEventListener("click", async ({ target }) => {
    if (filled || !(target instanceof HTMLButtonElement) || !target.closest(".panel")) return;
    await load("game");
    target.click();
  });
  listed();
  return load;
}
