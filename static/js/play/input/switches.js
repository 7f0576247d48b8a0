// The two switches on the marquee: sound, and ghost trails.

import { byId } from "../../util/dom.js";

/** @import { Ghost } from "../show/ghost.js" */
/** @import { Sound } from "../sound/sound.js" */

const GHOST_KEY = "plinko.ghost.1";

/** Off at first, always: a page that begins to sound by itself is a nuisance. @param {Sound} sound */
export function switchSound(sound) {
  const button = byId("sound");
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    sound.switch(on);
  });
}

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
