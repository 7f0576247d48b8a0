// Fields of the desk that find their values again in another tab, another day.

import { byId, fieldOf } from "../../util/dom.js";

const KEY = "plinko.desk.1";
const FIELDS = ["stake", "auto-count", "auto-rate"];
const CHOICES = { balls: ["1", "5", "20"], pace: ["real", "turbo", "instant"] };

/** Fills the fields with what was chosen last, and keeps what is chosen from now on. @param {Storage} storage */
export function keepFields(storage) {
  const kept = /** @type {Record<string, string>} */ (JSON.parse(storage.getItem(KEY) ?? "{}"));
  const fields = FIELDS.map((id) => /** @type {HTMLInputElement | HTMLSelectElement} */ (byId(id)));
  for (const field of fields) {
    const first = field.value;
    if (kept[field.id] !== undefined) field.value = kept[field.id];
    if (!field.checkValidity() || (field instanceof HTMLSelectElement && !field.value)) field.value = first;
  }
  const form = byId("drop-form", HTMLFormElement);
  const choices = Object.entries(CHOICES).map(([name, values]) => ({ name, values, field: fieldOf(form, name) }));
  for (const { name, values, field } of choices) if (values.includes(kept[name])) field.value = kept[name];
  form.addEventListener("change", () => {
    const values = fields.filter((field) => field.checkValidity()).map((field) => [field.id, field.value]);
    const chosen = choices.map(({ name, field }) => [name, field.value]);
    storage.setItem(KEY, JSON.stringify(Object.fromEntries([...values, ...chosen])));
  });
}
