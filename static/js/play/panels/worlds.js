// The choice of the world: a picture for each, with its average return where known.

import { isOwn, TABLES, worldName, worldWords } from "../../model/worlds.js";
import { boardName } from "../../model/presets.js";
import { paintSample } from "../../paint/sample.js";
import { fitted } from "../../util/canvas.js";
import { byId, make } from "../../util/dom.js";
import { percent } from "../../util/format.js";
import { returnsOf } from "./odds.js";

/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const TRY_KEY = "plinko.tried.1";
const TRY_AFTER = 10; // drops in the ordinary world

/** Fills the strip below the desk, and the one in the drawer. @param {Game} game @param {Theme} theme */
export function offerWorlds(game, theme) {
  for (const box of ["worlds", "places"]) fill(byId(box), game, theme);
}

/**
 * Radio buttons; a world that is not offered leaves all unchecked.
 * @param {HTMLElement} box @param {Game} game @param {Theme} theme
 */
function fill(box, game, theme) {
  const cards = TABLES.map((world) => {
    const words = worldWords(world.name);
    const radio = make("input", { type: "radio", name: box.id, value: world.name, "aria-label": words });
    const picture = make("canvas", { "aria-hidden": "true" });
    const share = make("small", { class: "place-share" });
    const label = make("span", { "aria-hidden": "true" }, words, share);
    box.append(make("label", { class: "place" }, radio, picture, label));
    radio.addEventListener("change", () => game.travel(world));
    return { world, radio, picture, share };
  });

  const showChoice = () => {
    const choice = game.played;
    for (const { radio, world } of cards) {
      radio.checked = choice?.gravity === world.gravity && choice.material === world.material;
      radio.disabled = choice === null || game.locked;
    }
  };
  const showShares = () => {
    const choice = game.played;
    for (const { share, world } of cards) {
      const known = choice && returnsOf(worldName(boardName(choice), world));
      share.textContent = known ? percent(known, 1) : "";
    }
  };
  const paint = () => {
    for (const { world: { name }, picture } of cards) {
      const { clientWidth: width, clientHeight: height } = picture;
      if (!width || !height) return;
      const look = theme.lookOf(name in theme.data.places ? name : null);
      paintSample(fitted(picture, { width, height }), { width, height }, window.devicePixelRatio || 1, look);
    }
  };
  // The pictures are painted once the box is visible.
  new ResizeObserver(paint).observe(box);
  theme.onChange(paint);
  // Odds that come while another table is fetched must not take the player's choice back.
  for (const kind of /** @type {const} */ (["table", "choice", "run", "room"])) game.on(kind, showChoice);
  for (const kind of /** @type {const} */ (["table", "choice", "odds"])) game.on(kind, showShares);
}

/** After some drops in the ordinary world, offers another world, once. @param {Game} game */
export function offerMoon(game) {
  const button = byId("try-moon");
  const show = () => {
    const { played, storage, account } = game;
    button.hidden = !played || !isOwn(played) || storage.getItem(TRY_KEY) !== null || account.balls < TRY_AFTER;
  };
  button.addEventListener("click", () => {
    const moon = TABLES.find(({ name }) => name === "Moon");
    if (moon) game.travel(moon);
  });
  game.on("table", () => {
    if (game.played && !isOwn(game.played)) game.storage.setItem(TRY_KEY, "yes");
    show();
  });
  game.on("account", show);
}
