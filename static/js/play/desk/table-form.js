// Which board is played: rows, risk and worlds on the desk, all else in the drawer "Table".

import { GRAVITY, OWN, RESTITUTION, restitutionOf, worldWords } from "../../model/worlds.js";
import { t } from "../../texts/text.js";
import { byId, make, radiosOf, radioValue } from "../../util/dom.js";
import { plain } from "../../util/format.js";
import { figure } from "../../util/scale.js";

/** @import { Game } from "../game.js" */
/** @import { TableChoice } from "../rooms.js" */

const ROWS = [8, 9, 10, 11, 12, 13, 14, 15, 16];

/** The fields by which a table is chosen. */
export class TableForm {
  /** @param {Game} game */
  constructor(game) {
    this.game = game;
    this.rows = byId("rows", HTMLSelectElement);
    this.risk = byId("risk", HTMLSelectElement);
    this.gravity = byId("gravity", HTMLSelectElement);
    this.material = byId("material", HTMLSelectElement);
    this.#fill();
    for (const field of [this.rows, this.gravity, this.risk, this.material, ...radiosOf("contact")]) {
      field.addEventListener("change", () => game.move(this.#choice));
    }
    byId("board-form", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
    game.on("table", () => this.#show());
    game.on("choice", () => this.#show());
  }

  #fill() {
    const option = (/** @type {string} */ value, /** @type {string} */ text) => make("option", { value }, text);
    this.rows.append(
      ...ROWS.map((rows) => option(String(rows), plain(rows))),
      option("classic", t("word.classic")), option("galton", t("word.galton")),
    );
    this.gravity.append(option(OWN, t("world.own")), ...Object.entries(GRAVITY).map(([name, value]) =>
      option(name, `${worldWords(name)} ${plain(value)}`)));
    this.material.append(option(OWN, t("world.own-material")), ...Object.keys(RESTITUTION).map((name) =>
      option(name, `${worldWords(name)} ${plain(restitutionOf(name))}`)));
  }

  /** @returns {TableChoice} */
  get #choice() {
    const rows = Number(this.rows.value);
    return {
      kind: rows ? "triangle" : /** @type {TableChoice["kind"]} */ (this.rows.value), rows,
      risk: /** @type {TableChoice["risk"]} */ (this.risk.value),
      gravity: this.gravity.value, material: this.material.value, knock: radioValue("contact") === "knock",
    };
  }

  /** As the room has it. */
  #show() {
    const { hello } = this.game.room;
    if (!hello || this.game.moving) return;
    const choice = this.game.played;
    for (const field of [this.rows, this.gravity, this.material]) field.disabled = choice === null;
    this.gravity.options[0].textContent = t("world.own-gravity", { g: figure(hello.board.gravity) });
    this.gravity.value = choice?.gravity ?? OWN;
    this.material.value = choice?.material ?? OWN;
    this.rows.value = choice?.kind === "triangle" ? String(choice.rows) : (choice?.kind ?? "");
    this.risk.disabled = choice?.kind !== "triangle";
    this.risk.value = choice?.risk ?? "medium";
    const knock = hello.mode === "interacting";
    for (const radio of radiosOf("contact")) radio.checked = (radio.value === "knock") === knock;
  }
}
