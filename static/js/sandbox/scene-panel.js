// The form that restarts a room or opens another: the scene, the number of balls and their sizes.

import { byId, fieldOf, inputOf } from "../util/dom.js";
import { noNumber, readNumber } from "../util/number-text.js";

/** @import { SceneForm, Settings } from "../model/messages.js" */

const NUMBERS = ["balls", "low", "high", "width", "height", "speed"];
const BOX = { radii: [0.06, 0.16], width: 6, height: 4, speed: 0 };

/** The fields of the "Scene" panel. */
export class ScenePanel {
  /**
   * @param {() => void} onBegin called to restart this room with the form's scene
   * @param {(text: string) => void} onInvalid called with a message if a field has no number
   */
  constructor(onBegin, onInvalid) {
    this.onInvalid = onInvalid;
    this.form = byId("scene-form", HTMLFormElement);
    this.panel = byId("scene-panel");
    this.form.addEventListener("change", () => this.#showFields());
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      onBegin();
    });
  }

  /**
   * @param {Settings} settings of the room, which become the scene's
   * @returns {(SceneForm & Record<string, unknown>) | null} null if a field has no number
   */
  read(settings) {
    const names = fieldOf(this.form, "scene").value === "galton" ? ["balls"] : NUMBERS;
    const wrong = names.map((name) => inputOf(this.form, name)).filter((field) => {
      const bad = readNumber(field.value) === null;
      field.setAttribute("aria-invalid", String(bad));
      return bad;
    });
    if (wrong.length > 0) {
      this.onInvalid(noNumber(wrong[0].value));
      wrong[0].focus();
      return null;
    }
    const number = (/** @type {string} */ name) => readNumber(inputOf(this.form, name).value) ?? 0;
    const seed = inputOf(this.form, "seed").value.trim() || "0";
    const common = { balls: number("balls"), seed };
    if (fieldOf(this.form, "scene").value === "galton") return { scene: "galton", ...common };
    return {
      scene: "sandbox", ...common, ...settings, speed: number("speed"),
      radii: [number("low"), number("high")], width: number("width"), height: number("height"),
    };
  }

  /** @param {SceneForm | null} scene of the room; null hides the form */
  show(scene) {
    this.panel.hidden = scene === null;
    if (scene === null) return;
    const { radii, width, height, speed } = { ...BOX, ...scene };
    const [low, high] = radii;
    fieldOf(this.form, "scene").value = scene.scene;
    const values = { balls: scene.balls, seed: scene.seed, low, high, width, height, speed };
    for (const [name, value] of Object.entries(values)) inputOf(this.form, name).value = String(value);
    this.#showFields();
  }

  #showFields() {
    const { value } = fieldOf(this.form, "scene");
    for (const part of document.querySelectorAll("[data-of]")) {
      if (part instanceof HTMLElement) part.hidden = part.dataset.of !== value;
    }
  }
}
