// The editor page: opens the board that the page's address contains or names.

import { openPage } from "../board/page.js";
import { getJson } from "../net/api.js";
import { boardInHash, unpackBoard } from "../net/board-link.js";
import { t } from "../texts/text.js";
import { complete, EMPTY } from "./draft/draft.js";
import { Editor } from "./editor.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */

/** @returns {Promise<{board: Board, said: string}>} said: message for the visitor */
async function firstBoard() {
  const packed = boardInHash(window.location.hash);
  if (packed !== null) {
    return { board: complete(await unpackBoard(packed)), said: t("editor.opened-link") };
  }
  const name = new URLSearchParams(window.location.search).get("board");
  if (!name) return { board: EMPTY, said: t("editor.opened-start") };
  const reply = await getJson(`boards/${encodeURIComponent(name)}`);
  const { board } = /** @type {BoardReply} */ (reply);
  return { board, said: t("editor.copy-of", { board: board.name }) };
}

openPage(async (theme) => {
  const editor = new Editor(theme);
  const { board, said } = await firstBoard();
  editor.open(board, said);
  window.addEventListener("hashchange", () => window.location.reload());
  await editor.keeping.listPresets();
});
