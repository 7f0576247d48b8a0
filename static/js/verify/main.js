// The page that checks a session's export, from a file or a link. It computes everything itself, without the server.

import { showState } from "../board/page.js";
import { openTools } from "../fairness/tools.js";
import { report } from "../fairness/report.js";
import { ExportError, readExport } from "../fairness/export.js";
import { t } from "../texts/text.js";
import { byId, inputOf, onSubmit, say } from "../util/dom.js";
import { local } from "../util/storage.js";
import { messageOf } from "../net/api.js";
import { showingToken } from "../net/session-token.js";
import { Theme } from "../paint/theme.js";
import { JsonError, textOfFile } from "../solver/input/json-text.js";

const EXPORT = /\/api\/v1\/sessions\/([^/]+)\/export$/;

const verdict = byId("verdict");
const list = byId("steps");
// Loaded at once, so that the check itself needs no network.
const tools = openTools();

/** @param {string} text an export @param {string} [key] the expected public key of the server */
async function check(text, key) {
  showState("checking", t("page.computing"));
  try {
    const session = readExport(text);
    byId("key-shown").textContent = session.key;
    const failed = await report(session, { ...(await tools), ...(key && { key }) }, { verdict, list });
    if (failed.length > 0) showState("forged", t("page.failed"));
    else showState("proven", t("play.ready"));
  } catch (error) {
    refuse(error);
  }
}

/** @param {File} file */
async function checkFile(file) {
  try {
    await check(await textOfFile(file), key());
  } catch (error) {
    refuse(error);
  }
}

/** @param {unknown} error */
function refuse(error) {
  showState("failed", t("page.failed"));
  list.replaceChildren();
  say(verdict, "bad", error instanceof ExportError || error instanceof JsonError ? t("check.no-session", { why: error.message }) : messageOf(error));
}

/** @param {string} link */
async function checkLink(link) {
  try {
    const { origin, pathname } = new URL(link, document.baseURI);
    const session = origin === window.location.origin ? EXPORT.exec(pathname)?.[1] : undefined;
    // The player's token, which this site requires for its exports.
    const shown = session === undefined ? {} : showingToken(local, decodeURIComponent(session));
    const response = await fetch(link, shown);
    if (!response.ok) throw new Error(t("check.missing", { address: link, status: String(response.status) }));
    await check(await response.text(), key());
  } catch (error) {
    refuse(error);
  }
}

new Theme();

const form = byId("other", HTMLFormElement);
const key = () => inputOf(form, "key").value.trim().toLowerCase();

byId("file", HTMLInputElement).addEventListener("change", async ({ target }) => {
  const [file] = /** @type {HTMLInputElement} */ (target).files ?? [];
  if (file) await checkFile(file);
});
onSubmit("other", async () => {
  const link = inputOf(form, "link").value.trim();
  const [file] = byId("file", HTMLInputElement).files ?? [];
  if (link) await checkLink(link);
  else if (file) await checkFile(file);
});

const asked = new URLSearchParams(window.location.search).get("session");
if (asked !== null) {
  // For a session of this site, its ID is enough.
  const link = `api/v1/sessions/${encodeURIComponent(asked)}/export`;
  inputOf(form, "link").value = link;
  checkLink(link);
}
document.documentElement.dataset.ready = "true";
