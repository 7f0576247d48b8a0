// The tray below the board: landed balls as bars or as a pile, the expected counts, and their number.

import { Histogram } from "../../instruments/histogram.js";
import { t } from "../../texts/text.js";
import { recorded } from "../../model/odds.js";
import { byId, onClick } from "../../util/dom.js";

/** @import { Expectation } from "../../instruments/histogram.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const PILE_KEY = "plinko.pile.1";
const RENEWED_MS = 200;

/**
 * Shows the pile unless the player has chosen bars. The pile's code is fetched at the first touch or key.
 * @param {Game} game @param {Theme} theme
 */
export function showTray(game, theme) {
  const histogram = new Histogram(byId("histogram", HTMLCanvasElement), theme);
  let wanted = game.storage.getItem(PILE_KEY) !== "off";
  let fetched = false;
  let shown = byId("tray-count").textContent;
  let shownMs = 0;

  const showSwitch = () => byId("pile").setAttribute("aria-pressed", String(wanted));
  const fetch = async () => {
    fetched = true;
    const asked = wanted;
    showSwitch();
    try {
      const pile = asked ? await (await import("../../instruments/pile/pile.js")).openPile(theme) : null;
      if (asked === wanted) histogram.setPile(pile);
    } catch {
      wanted = false;
      showSwitch();
      game.say(t("play.pile-fails"), { urgent: true });
    }
    game.tell("picture", null);
  };
  showSwitch();
  onClick("pile", () => {
    wanted = !wanted;
    game.storage.setItem(PILE_KEY, wanted ? "on" : "off");
    void fetch();
  });
  const first = () => { if (!fetched) void fetch(); };
  for (const gesture of ["pointermove", "pointerdown", "keydown"]) {
    document.addEventListener(gesture, first, { once: true });
  }
  game.on("run", () => { if (game.busy) first(); }); // balls of ours that fall without a touch of this page
  game.on("hit", ({ bin, entry }) => {
    histogram.add(bin, entry);
    game.tell("picture", null);
  });
  /** @param {Expectation | null} expected */
  const expect = (expected) => {
    byId("tray-key").hidden = !expected;
    histogram.setExpected(expected);
    game.tell("picture", null);
  };
  game.on("odds", (odds) => expect(odds && recorded(odds)));
  game.on("expected", expect); // what the Lab compares with
  theme.onChange(() => histogram.draw());

  /**
   * @param {number} nowMs @param {boolean} still whether motion is reduced
   * @returns {boolean} whether to call it again soon
   */
  const show = (nowMs, still) => {
    histogram.refresh(nowMs, still);
    const text = histogram.words;
    const due = text !== shown;
    if (due && nowMs - shownMs >= RENEWED_MS) {
      shown = text;
      shownMs = nowMs;
      byId("tray-count").textContent = text;
    }
    return due || histogram.pending;
  };
  return { histogram, show };
}
