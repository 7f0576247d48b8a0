// One value of a fair session on the page.

import { t } from "../texts/text.js";
import { make } from "../util/dom.js";
import { canonical } from "./canonical.js";

/** A value with a button that copies it. @param {string} name @param {unknown} content */
export function value(name, content) {
  const text = typeof content === "string" ? content : canonical(content);
  const copy = make("button", { type: "button", class: "fair-copy", "aria-label": t("check.copy-what", { name }) }, t("check.copy"));
  copy.addEventListener("click", async () => {
    await navigator.clipboard.writeText(text);
    copy.textContent = t("check.copied");
  });
  return make("p", { class: "fair-value" }, make("span", {}, name), make("code", {}, text), copy);
}
