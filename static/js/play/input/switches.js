// The switches of ghost trails, and between bars and the pile.

import { openPile } from "../../instruments/pile/pile.js";
import { messageOf } from "../../net/api.js";
import { t } from "../../texts/text.js";
import { byId } from "../../util/dom.js";

/** @import { Histogram } from "../../instruments/histogram.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Ghost } from "../show/ghost.js" */

const GHOST_KEY = "plinko.ghost.1";
const PILE_KEY = "plinko.pile.1";

/** @param {Ghost} ghost @param {() => void} onChange */
export function switchGhost(ghost, onChange) {
  const button = byId("ghost");
  /** @param {boolean} on */
  const set = (on) => {
    ghost.on = on;
    button.setAttribute("aria-pressed", String(on));
  };
  set(window.localStorage.getItem(GHOST_KEY) !== "off");
  button.addEventListener("click", () => {
    set(!ghost.on);
    window.localStorage.setItem(GHOST_KEY, ghost.on ? "on" : "off");
    onChange();
  });
}

/**
 * What moves the pile is fetched when it is first chosen.
 * @param {Histogram} histogram
 * @param {Theme} theme
 * @param {{onChange: () => void, say: (text: string) => void}} listener
 */
export function switchPile(histogram, theme, { onChange, say }) {
  const button = byId("pile");
  let on = false;
  /** @param {boolean} wanted */
  const set = async (wanted) => {
    on = wanted;
    button.setAttribute("aria-pressed", String(on));
    const pile = on ? await openPile(theme) : null;
    if (on !== wanted) return; // it was pressed again meanwhile
    histogram.setPile(pile);
    onChange();
  };
  /** @param {boolean} wanted */
  const attempt = (wanted) => set(wanted).catch((error) => {
    say(t("play.pile-fails", { why: messageOf(error) }));
    return set(false);
  });
  if (window.localStorage.getItem(PILE_KEY) === "on") void attempt(true);
  button.addEventListener("click", () => {
    window.localStorage.setItem(PILE_KEY, on ? "off" : "on");
    void attempt(!on);
  });
}
