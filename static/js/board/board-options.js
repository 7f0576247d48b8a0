// The options of a list of boards: those of the house table first, then a group for each world.

import { WORLDS } from "../model/presets.js";
import { worldWords } from "../model/worlds.js";
import { make } from "../util/dom.js";

/**
 * @param {{value: string, name: string, world: string | null}[]} boards
 * @returns {HTMLElement[]} options and groups of options
 */
export function boardOptions(boards) {
  const [, ...away] = WORLDS;
  const of = (/** @type {(world: string | null) => boolean} */ fits) =>
    boards.filter(({ world }) => fits(world)).map(({ value, name }) => make("option", { value }, name));
  return [
    ...of((world) => world === null || !away.includes(world)),
    ...away.map((name) => make("optgroup", { label: worldWords(name) }, ...of((world) => world === name))),
  ];
}
