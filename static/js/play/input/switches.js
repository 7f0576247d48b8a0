// The switch of ghost trails.

import { byId } from "../../util/dom.js";

/** @import { Ghost } from "../show/ghost.js" */

const GHOST_KEY = "plinko.ghost.1";

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
