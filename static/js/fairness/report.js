// Shows the checks of a fair session on the page: which hold, both values of each, and the verdict. The table's page
// fetches it for the first check.

import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { make, say } from "../util/dom.js";
import { checkSession } from "./check.js";
import { hexOf, sha256 } from "./crypto.js";
import { value } from "./value.js";

/** @import { Step, Tools } from "./check.js" */
/** @import { SessionExport } from "./export.js" */

const MOST_ROWS = 50; // of drops that hold

/** @typedef {{verdict: HTMLElement, list: HTMLElement}} Places elements for the verdict and the steps */

export { readExport } from "./export.js";

/** Loads the solver and its digest. @returns {Promise<Tools>} */
export async function openTools() {
  const url = new URL("../solver/kernels.wasm", import.meta.url);
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href} could not be loaded: HTTP status ${response.status}`);
  const bytes = await response.arrayBuffer();
  return { solver: await openSolver(bytes), kernelDigest: hexOf(await sha256(new Uint8Array(bytes))) };
}

/**
 * Checks a session and shows the result.
 * @param {SessionExport} session
 * @param {Tools} tools
 * @param {Places} places
 * @returns {Promise<Step[]>} the steps that failed
 */
export async function report(session, tools, { verdict, list }) {
  say(verdict, "", t("page.computing"));
  list.replaceChildren();
  /** @type {Map<number | null, Step[]>} */
  const groups = new Map();
  const failed = [];
  for await (const step of checkSession(session, tools)) {
    groups.set(step.drop, [...(groups.get(step.drop) ?? []), step]);
    if (!step.ok) failed.push(step);
  }
  list.append(...rowsOf([...groups]));
  const names = [...new Set(failed.map(({ name, drop }) => (drop === null ? name : t("check.of-drop", { name, drop }))))];
  if (failed.length > 0) say(verdict, "bad", `${t("check.forged")} ${names.slice(0, 8).join(", ")}.`);
  // Without the statement that the player received first, the server could have chosen its seed late.
  else say(verdict, "good", session.heard_session ? t("check.proven") : t("check.proven-late"));
  return failed;
}

/**
 * A row for the session and one for each drop. Of many drops, those that hold share a row, whose rows are made when
 * the reader opens it.
 * @param {[number | null, Step[]][]} groups
 */
function rowsOf(groups) {
  const row = (/** @type {[number | null, Step[]]} */ [drop, steps]) => group(drop, steps);
  const holds = groups.filter(([drop, steps]) => drop !== null && steps.every(({ ok }) => ok));
  if (holds.length <= MOST_ROWS) return groups.map(row);
  const summary = make("summary", {}, mark(true), " ", t("check.drops-hold", { n: holds.length }));
  const details = make("details", { class: "fair-group", "data-ok": "true" }, summary);
  details.addEventListener("toggle", () => {
    if (details.open && details.children.length === 1) details.append(make("ol", { class: "fair-list" }, ...holds.map(row)));
  });
  return [...groups.filter((each) => !holds.includes(each)).map(row), make("li", {}, details)];
}

/** @param {number | null} drop @param {Step[]} steps */
function group(drop, steps) {
  const ok = steps.every((step) => step.ok);
  const n = steps.length;
  const title = drop === null ? t("check.session-steps", { n }) : t("check.drop-steps", { drop, n });
  const summary = make("summary", {}, mark(ok), " ", title);
  const details = make("details", { class: "fair-group", "data-ok": String(ok) }, summary);
  // A long session has thousands of values, so each table is made when the reader opens it.
  details.addEventListener("toggle", () => {
    if (details.open && details.children.length === 1) details.append(table(steps));
  });
  details.open = !ok;
  return make("li", {}, details);
}

/** @param {Step[]} steps */
function table(steps) {
  return make("ul", { class: "fair-steps" }, ...steps.map((step) => make(
    "li", { "data-step": step.name, "data-ok": String(step.ok) },
    make("p", {}, mark(step.ok), " ", make("b", {}, step.name), `: ${t(step.text)}`),
    value(t("check.said"), step.said), value(t("check.found"), step.found),
  )));
}

/** @param {boolean} ok */
const mark = (ok) => make("span", { class: "fair-mark" }, ok ? "✓" : "✗");
