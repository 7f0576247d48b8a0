// The buttons and files that have this page recompute a drop or a room's log. verify.js is loaded for the first of them.

import { t } from "../texts/text.js";
import { byId, onClick, say } from "../util/dom.js";

/** @import { ImpactList } from "./impact-list.js" */
/** @import { Replay } from "./replay.js" */

/** @param {HTMLElement} note says that the code cannot be fetched @returns {Promise<typeof import("./verify.js") | null>} */
async function loaded(note) {
  const code = await import("./verify.js").catch(() => null);
  if (!code) say(note, "bad", t("play.part-fails"));
  return code;
}

/** @param {Replay} replay @param {ImpactList} list marks its impacts as verified */
export function offerVerify(replay, list) {
  onClick("verify", async () => (await loaded(byId("verdict")))?.verify(replay, list));
}

/** Connects the panel, and accepts files dropped anywhere on the page. */
export function offerFileCheck() {
  const field = byId("check-file", HTMLInputElement);
  /** @param {File | undefined} file */
  const check = async (file) => {
    if (file) await (await loaded(byId("check-note")))?.checkFile(file);
  };
  onClick("check-open", () => field.click());
  field.addEventListener("change", () => {
    void check(field.files?.[0]);
    field.value = ""; // the same file can be chosen again
  });
  document.addEventListener("dragover", (event) => {
    if (event.dataTransfer?.types.includes("Files")) event.preventDefault();
  });
  document.addEventListener("drop", (event) => {
    const dropped = event.dataTransfer?.files[0];
    if (!dropped) return;
    event.preventDefault();
    byId("curious", HTMLDetailsElement).open = true;
    byId("check-panel").scrollIntoView({ block: "nearest" });
    void check(dropped);
  });
}
