// The tables as places: seven pictures of which one is chosen, by one tap.

import { TABLES, worldWords } from "../../model/worlds.js";
import { paintSample } from "../../paint/sample.js";
import { fitted } from "../../util/canvas.js";
import { byId, make } from "../../util/dom.js";

/** @import { World } from "../../model/worlds.js" */
/** @import { Theme } from "../../paint/theme.js" */

const NAME = "place";

/** Radio buttons in the form of the table. A world that is none of them leaves all unchecked. */
export class Tables {
  /** @type {Map<string, {radio: HTMLInputElement, picture: HTMLCanvasElement}>} */
  #cards = new Map();

  /** @param {Theme} theme @param {(world: World) => void} onChoose */
  constructor(theme, onChoose) {
    this.theme = theme;
    const box = byId("places");
    for (const table of TABLES) {
      const { name } = table;
      const words = worldWords(name);
      const radio = make("input", { type: "radio", name: NAME, value: name, "aria-label": words });
      const picture = make("canvas", { "aria-hidden": "true" });
      const label = make("span", { "aria-hidden": "true" }, words);
      box.append(make("label", { class: "place" }, radio, picture, label));
      this.#cards.set(name, { radio, picture });
      radio.addEventListener("change", () => onChoose(table));
    }
    // Nothing is painted before it is looked at.
    new ResizeObserver(() => this.paint()).observe(box);
    theme.onChange(() => this.paint());
  }

  /** @param {string | null} name of the table that is played at */
  show(name) {
    for (const [of, { radio }] of this.#cards) radio.checked = of === name;
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
