// The keys of the live table. Where the player types, a key keeps its meaning.

import { isWithin } from "../../util/dom.js";

const TYPED_INTO = "input:not([type=range], [type=radio], [type=checkbox]), select, textarea, dialog";
// Elements where Space has a use already, for a player who reached them by keyboard: it types a space, moves a slider or
// presses the button.
const OWN_SPACE = "button, a, select, summary, input:not([type=radio]:checked)";
const TEXTS = "textarea, dialog, input:not([type=radio], [type=checkbox], [type=range], [inputmode])";

/** @param {KeyboardEvent} event */
const isModified = ({ ctrlKey, altKey, metaKey }) => ctrlKey || altKey || metaKey;

/** @param {string[]} keys in small letters @param {(event: KeyboardEvent) => void} press */
export function onKey(keys, press) {
  document.addEventListener("keydown", (event) => {
    if (keys.includes(event.key.toLowerCase()) && !isModified(event) && !isWithin(event, TYPED_INTO)) press(event);
  });
}

/**
 * Space acts, whatever was clicked before. Where the keyboard has led, it keeps the meaning that it has there.
 * @param {() => void} press
 */
export function onSpace(press) {
  let pointed = false; // whether the last thing that the player did was a click or a touch
  /** @param {KeyboardEvent} event */
  const acts = (event) => !isWithin(event, TEXTS) && (pointed || !isWithin(event, OWN_SPACE));
  document.addEventListener("pointerdown", () => { pointed = true; }, true);
  document.addEventListener("keydown", (event) => {
    if (isModified(event)) return;
    if (event.key !== " ") {
      pointed = false;
      return;
    }
    if (acts(event) || isWithin(event, "[inputmode]")) event.preventDefault(); // a number has no space
    if (acts(event) && !event.repeat) press();
  });
  document.addEventListener("keyup", (event) => {
    if (event.key === " " && acts(event)) event.preventDefault(); // else some browsers click a focused button
  });
}
