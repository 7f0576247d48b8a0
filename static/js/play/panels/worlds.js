// The choice of the world: a picture for each.

import { HOUSE, WORLDS } from "../../model/presets.js";
import { isOwn, worldWords } from "../../model/worlds.js";
import { paintSample } from "../../paint/sample.js";
import { fitted } from "../../util/canvas.js";
import { byId, make } from "../../util/dom.js";
import { pause } from "../../util/frame-loop.js";

/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

/** Fills the strip below the desk, and the one in the drawer. @param {Game} game @param {Theme} theme */
export function offerWorlds(game, theme) {
  for (const box of ["worlds", "places"]) fill(byId(box), game, theme);
}

/**
 * Radio buttons; a board with a custom gravity or material leaves all unchecked.
 * @param {HTMLElement} box @param {Game} game @param {Theme} theme
 */
function fill(box, game, theme) {
  const cards = WORLDS.map((world) => {
    const words = worldWords(world);
    const radio = make("input", { type: "radio", name: box.id, value: world, "aria-label": words });
    const picture = make("canvas", { "aria-hidden": "true" });
    const label = make("span", { "aria-hidden": "true" }, words);
    box.append(make("label", { class: "place" }, radio, picture, label));
    radio.addEventListener("change", () => game.travel(world));
    return { world, radio, picture };
  });

  const showChoice = () => {
    const choice = game.played;
    for (const { radio, world } of cards) {
      if (game.room.hello && !game.moving) radio.checked = choice?.world === world && isOwn(choice);
      radio.disabled = choice === null || game.locked;
    }
  };
  let turn = 0;
  const paint = async () => {
    const own = (turn += 1);
    for (const { world, picture } of cards) {
      await pause();
      if (own !== turn) return; // the size or the colours have changed meanwhile
      const { clientWidth: width, clientHeight: height } = picture;
      if (!width || !height) return;
      const look = theme.lookOf(world === HOUSE ? null : world);
      paintSample(fitted(picture, { width, height }), { width, height }, window.devicePixelRatio || 1, look);
    }
  };
  // The pictures are painted once the box is visible.
  new ResizeObserver(paint).observe(box);
  theme.onChange(paint);
  for (const kind of /** @type {const} */ (["table", "choice", "run", "room"])) game.on(kind, showChoice);
}
