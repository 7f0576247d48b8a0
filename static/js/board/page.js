// What the pages that look at drops share: start-up, failures told, links, the form's board list.

import { MAIN_BOARD, MAIN_ROOM, readBoardName } from "../model/presets.js";
import { Visited } from "../model/player/visited.js";
import { readSeed } from "../model/seed.js";
import { ApiError, getJson, messageOf } from "../net/api.js";
import { LinkError } from "../net/board-link.js";
import { dropSearch } from "../net/drop-address.js";
import { Theme } from "../paint/theme.js";
import { t } from "../texts/text.js";
import { byId, make, say } from "../util/dom.js";
import { keepOffline } from "../util/offline.js";

/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { BoardList } from "../net/replies.js" */

/** What is shown where an address names nothing. */
export const DEFAULT_BOARD = MAIN_BOARD;
export const DEFAULT_SEED = "42";

/**
 * Runs a page and shows what stops it.
 * @param {(theme: Theme) => Promise<void> | void} open
 */
export async function openPage(open) {
  keepOffline();
  try {
    await open(await Theme.load());
  } catch (error) {
    showState("failed", t("page.failed"));
    byId("result").textContent = messageOf(error);
    // A refusal by the server is told to the visitor; anything else is a fault to be seen.
    if (!(error instanceof ApiError || error instanceof LinkError)) throw error;
  }
}

/** @param {string} state @param {string} text of the lamp */
export function showState(state, text) {
  document.documentElement.dataset.state = state;
  byId("state-text").textContent = text;
}

/**
 * @param {string} board what REST calls it
 * @returns {string} link back to where the visitor played, or else to this board's own table
 */
function tableLink(board) {
  const room = new Visited(window.localStorage).room || (readBoardName(board) ? board : MAIN_ROOM);
  return room === MAIN_ROOM ? "./" : `./?${new URLSearchParams({ room })}`;
}

/**
 * Fills the form that asks for another drop with the boards the server knows.
 * @param {string} value of the one that is shown, as REST calls it; listed even if the server's list lacks it
 * @param {string} name its own
 */
export async function fillBoards(value, name) {
  const select = byId("other-board", HTMLSelectElement);
  const { boards } = /** @type {BoardList} */ (await getJson("boards"));
  const listed = boards.map((board) => ({
    value: board.preset ? board.name : board.digest,
    name: board.preset ? board.name : `${board.name} (${board.digest.slice(0, 8)})`,
  }));
  if (!listed.some((board) => board.value === value)) listed.unshift({ value, name });
  select.replaceChildren(...listed.map((board) => make("option", { value: board.value }, board.name)));
  select.value = value;
}

/**
 * Whether fields of the form that asks for another drop hold seeds; the first that does not is named and entered.
 * @param {HTMLInputElement[]} fields @param {string} needs what is said of an empty one
 */
export function holdSeeds(fields, needs) {
  const note = byId("other-note");
  for (const field of fields) {
    const reading = readSeed(field.value);
    const good = reading.ok && reading.seed !== null;
    field.setAttribute("aria-invalid", String(!good));
    note.hidden = good;
    if (good) {
      field.value = String(reading.seed); // without zeros before it
      continue;
    }
    say(note, "bad", reading.ok ? needs : reading.message);
    field.focus();
    return false;
  }
  return true;
}

/** Links to the other pages lead to the drop that is looked at. @param {DropAddress} drop */
export function linkPages(drop) {
  const { hash } = window.location; // which may hold the board
  const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
  const links = {
    "to-table": tableLink(drop.board), back: tableLink(drop.board),
    "to-replay": `replay.html?${search}${hash}`, "to-compare": `compare.html?${search}${hash}`,
    "to-editor": hash ? `editor.html${hash}` : `editor.html?board=${drop.board}`,
  };
  for (const [id, href] of Object.entries(links)) {
    const link = byId(id, HTMLAnchorElement);
    if (!link.hasAttribute("aria-current")) link.href = href;
  }
}
