// The page that checks a session's export, from a file or a link. It computes everything itself, without the server.

import { showState } from "../board/page.js";
import { ExportError } from "../fairness/export.js";
import { openTools, readExport, report } from "../fairness/report.js";
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

const form = byId("other", HTMLFormElement);

/** Checks an export, and shows what is found. @param {() => Promise<string>} read returns its text */
async function check(read) {
  showState("checking", t("page.computing"));
  try {
    const session = readExport(await read());
    const key = inputOf(form, "key").value.trim().toLowerCase(); // the expected public key of the server
    byId("key-shown").textContent = session.key;
    const failed = await report(session, { ...(await tools), ...(key && { key }) }, { verdict, list });
    if (failed.length > 0) showState("forged", t("page.failed"));
    else showState("proven", t("play.ready"));
  } catch (error) {
    showState("failed", t("page.failed"));
    list.replaceChildren();
    const named = error instanceof ExportError || error instanceof JsonError;
    say(verdict, "bad", named ? t("check.no-session", { why: error.message }) : messageOf(error));
  }
}

/** @param {string} link @returns {Promise<string>} */
async function textAt(link) {
  const { origin, pathname } = new URL(link, document.baseURI);
  const session = origin === window.location.origin ? EXPORT.exec(pathname)?.[1] : undefined;
  // The player's token, which this site requires for its exports.
  const shown = session === undefined ? {} : showingToken(local, decodeURIComponent(session));
  const response = await fetch(link, shown);
  if (!response.ok) throw new Error(t("check.missing", { address: link, status: String(response.status) }));
  return response.text();
}

/** Checks what the form names. */
function checkNamed() {
  const link = inputOf(form, "link").value.trim();
  const [file] = byId("file", HTMLInputElement).files ?? [];
  if (link) void check(() => textAt(link));
  else if (file) void check(() => textOfFile(file));
}

new Theme();
byId("file").addEventListener("change", () => {
  const [file] = byId("file", HTMLInputElement).files ?? [];
  if (file) void check(() => textOfFile(file));
});
onSubmit("other", checkNamed);
const asked = new URLSearchParams(window.location.search).get("session");
if (asked !== null) {
  // For a session of this site, its ID is enough.
  inputOf(form, "link").value = `api/v1/sessions/${encodeURIComponent(asked)}/export`;
  checkNamed();
}
document.documentElement.dataset.ready = "true";
