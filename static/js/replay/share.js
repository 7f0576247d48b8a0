// The panel for sharing a drop: a link, a frame for other sites, a poster, a film, a video, the record.

import { messageOf } from "../net/api.js";
import { hasServer } from "../net/ask.js";
import { dropPath, dropSearch } from "../net/drop-address.js";
import { saveVideo } from "../net/video.js";
import { t } from "../texts/text.js";
import { copyFrom } from "../util/copy.js";
import { byId, onClick } from "../util/dom.js";

/** @import { DropRecord } from "../model/motion/drop.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Key } from "../texts/text.js" */

const POSTER_WIDTH = "1200"; // pixels
const FILM_WIDTH = "480";
/** @type {[string, string, string, Record<string, string>][]} id of the link, end of the path, of the file, query */
const FILES = [
  ["share-poster", ".png", ".png", { width: POSTER_WIDTH }], ["share-film", ".webp", ".webp", { width: FILM_WIDTH }],
  ["share-record", "", ".json", {}],
];
const FRAME = { width: 520, height: 580 }; // CSS pixels, for a board about as wide as high

/** @param {DropAddress} drop @param {string} hash of the address, which may contain the board @param {DropRecord} record */
export function offerShare(drop, hash, record) {
  const note = byId("share-note");
  const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
  const name = `plinko-${drop.seed}`;
  for (const [id, part, end, query] of FILES) {
    const link = byId(id, HTMLAnchorElement);
    link.href = `api/v1/${dropPath(drop, part, new URLSearchParams(query))}`;
    link.download = `${name}${end}`;
  }
  if (!hasServer) {
    const file = new Blob([`${JSON.stringify(record)}\n`], { type: "application/json" });
    byId("share-record", HTMLAnchorElement).href = URL.createObjectURL(file);
  }
  /** @param {string} id @param {string} text @param {Key} copied @param {Key} marked message for a copied, and for a selected text */
  const offer = (id, text, copied, marked) => onClick(id, async () => {
    note.textContent = t((await copyFrom(byId("share-text", HTMLInputElement), text)) ? copied : marked);
  });
  const link = new URL(`replay.html?${search}&guess${hash}`, document.baseURI).href;
  offer("share-link", link, "replay.link-copied", "replay.link-marked");
  const frame = frameOf(new URL(`replay.html?${search}&embed${hash}`, document.baseURI).href, t("replay.frame-title", { seed: drop.seed }));
  offer("share-frame", frame, "replay.frame-copied", "replay.frame-marked");
  const video = byId("share-video", HTMLButtonElement);
  video.addEventListener("click", async () => {
    video.disabled = true;
    note.textContent = t("page.computing");
    try {
      await saveVideo(drop);
      note.textContent = t("replay.share-note");
    } catch (error) {
      note.textContent = messageOf(error);
    }
    video.disabled = false;
  });
  for (const id of ["share-link", "share-frame", "share-video"]) byId(id, HTMLButtonElement).disabled = false;
}

/** @param {string} address @param {string} title @returns {string} HTML of the frame */
function frameOf(address, title) {
  const source = address.replaceAll("&", "&amp;").replaceAll('"', "&quot;");
  const { width, height } = FRAME;
  return `<iframe src="${source}" title="${title} – Plinko" width="${width}" height="${height}" `
    + 'style="border:0" loading="lazy"></iframe>';
}
