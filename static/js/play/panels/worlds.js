// The worlds to play in: pictures of which one is chosen by one tap, with what each gives back where it is known.

import { isOwn, TABLES, worldName, worldWords } from "../../model/worlds.js";
import { boardName } from "../../model/presets.js";
import { paintSample } from "../../paint/sample.js";
import { fitted } from "../../util/canvas.js";
import { byId, make } from "../../util/dom.js";
import { percent } from "../../util/format.js";
import { returnsOf } from "./odds.js";

/** @import { World } from "../../model/worlds.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const TRY_KEY = "plinko.tried.1";
const TRY_AFTER = 10; // drops at home

/** Radio buttons in one of the page's boxes. A world that is none of them leaves all unchecked. */
export class Worlds {
  /** @type {Map<string, {radio: HTMLInputElement, picture: HTMLCanvasElement, share: HTMLElement, world: World}>} */
  #cards = new Map();

  /** @param {Game} game @param {Theme} theme @param {string} box */
  constructor(game, theme, box) {
    this.game = game;
    this.theme = theme;
    this.box = byId(box);
    for (const world of TABLES) this.#add(world);
    // Nothing is painted before it is looked at.
    new ResizeObserver(() => this.paint()).observe(this.box);
    theme.onChange(() => this.paint());
    game.on("table", () => this.#show());
    game.on("choice", () => this.#show());
    game.on("odds", () => this.#show());
  }

  /** @param {World & {name: string}} world */
  #add(world) {
    const { name } = world;
    const words = worldWords(name);
    const radio = make("input", { type: "radio", name: this.box.id, value: name, "aria-label": words });
    const picture = make("canvas", { "aria-hidden": "true" });
    const share = make("small", { class: "place-share" });
    const label = make("span", { "aria-hidden": "true" }, words, share);
    this.box.append(make("label", { class: "place" }, radio, picture, label));
    this.#cards.set(name, { radio, picture, share, world });
    radio.addEventListener("change", () => this.game.travel(world));
  }

  #show() {
    const choice = this.game.played;
    for (const { radio, share, world } of this.#cards.values()) {
      const { gravity, material } = world;
      radio.checked = choice?.gravity === gravity && choice.material === material;
      radio.disabled = choice === null;
      const known = choice && returnsOf(worldName(boardName(choice), world));
      share.textContent = known ? percent(known, 1) : "";
    }
  }

  paint() {
    const density = window.devicePixelRatio || 1;
    for (const [name, { picture }] of this.#cards) {
      const { clientWidth: width, clientHeight: height } = picture;
      if (!width || !height) return;
      const look = this.theme.lookOf(name in this.theme.data.places ? name : null);
      paintSample(fitted(picture, { width, height }), { width, height }, density, look);
    }
  }
}

/** After some drops at home another world is offered, once. */
export class TryMoon {
  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.button = byId("try-moon");
    this.button.addEventListener("click", () => {
      const moon = TABLES.find(({ name }) => name === "Moon");
      if (moon) game.travel(moon);
    });
    game.on("table", () => {
      if (game.played && !isOwn(game.played)) game.storage.setItem(TRY_KEY, "yes");
      this.#show();
    });
    game.on("account", () => this.#show());
  }

  #show() {
    const { played } = this.game;
    this.button.hidden = !played || !isOwn(played) || this.game.storage.getItem(TRY_KEY) !== null
      || this.game.account.balls < TRY_AFTER;
  }
}
