// The choice of the board: rows, risk and worlds on the desk, everything else in the drawer "Table".

import { HOUSE } from "../../model/presets.js";
import { GRAVITY, isOwn, OWN, RESTITUTION, restitutionOf, worldWords } from "../../model/worlds.js";
import { t } from "../../texts/text.js";
import { byId, check, make, onChoice, onSubmit, radiosOf, radioValue } from "../../util/dom.js";
import { plain } from "../../util/format.js";

/** @import { Game } from "../game.js" */
/** @import { TableChoice } from "../rooms.js" */

const ROWS = [8, 9, 10, 11, 12, 13, 14, 15, 16];

/** @param {Game} game */
export function offerTables(game) {
  const [rows, risk, gravity, material] = ["rows", "risk", "gravity", "material"].map((id) =>
    byId(id, HTMLSelectElement));
  const option = (/** @type {string} */ value, /** @type {string} */ text) => make("option", { value }, text);
  rows.append(
    ...ROWS.map((count) => option(String(count), plain(count))),
    option("classic", t("word.classic")), option("galton", t("word.galton")),
  );
  gravity.append(option(OWN, t("world.own")), ...Object.entries(GRAVITY).map(([name, value]) =>
    option(name, `${worldWords(name)} ${plain(value)}`)));
  material.append(option(OWN, t("world.own-material")), ...Object.keys(RESTITUTION).map((name) =>
    option(name, `${worldWords(name)} ${plain(restitutionOf(name))}`)));

  const move = () => {
    const count = Number(rows.value);
    // A custom gravity or material replaces the house table's.
    const own = count && isOwn({ gravity: gravity.value, material: material.value });
    return game.move({
      kind: count ? "triangle" : /** @type {TableChoice["kind"]} */ (rows.value),
      world: (own && game.played?.world) || HOUSE, rows: count,
      risk: /** @type {TableChoice["risk"]} */ (risk.value),
      gravity: gravity.value, material: material.value, knock: radioValue("contact") === "knock",
    });
  };
  for (const field of [rows, risk, gravity, material]) field.addEventListener("change", move);
  onChoice("contact", move);
  onSubmit("board-form");

  /** Shows the room's own values. */
  const show = () => {
    const { hello } = game.room;
    if (!hello || game.moving) return;
    const choice = game.played;
    const locked = game.locked;
    for (const field of [rows, gravity, material, ...radiosOf("contact")]) field.disabled = choice === null || locked;
    for (const field of [rows, risk]) field.title = locked ? t("play.locked") : "";
    gravity.options[0].textContent = t("world.own-gravity", { g: plain(hello.board.gravity) });
    gravity.value = choice?.gravity ?? OWN;
    material.value = choice?.material ?? OWN;
    rows.value = choice?.kind === "triangle" ? String(choice.rows) : (choice?.kind ?? "");
    risk.hidden = choice?.kind !== "triangle";
    risk.disabled = risk.hidden || locked;
    risk.value = choice?.risk ?? "medium";
    check("contact", hello.mode === "interacting" ? "knock" : "pass");
  };
  for (const kind of /** @type {const} */ (["table", "choice", "run", "room"])) game.on(kind, show);
}
