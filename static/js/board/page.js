// Code that the pages about drops share: start-up, failures, links, and the form for another drop.

import { MAIN_ROOM, readBoardName, WORLDS } from "../model/presets.js";
import { Visited } from "../model/player/visited.js";
import { readSeed } from "../model/seed.js";
import { worldWords } from "../model/worlds.js";
import { ApiError, getJson, messageOf } from "../net/api.js";
import { LinkError } from "../net/board-link.js";
import { dropSearch } from "../net/drop-address.js";
import { Theme } from "../paint/theme.js";
import { number, t } from "../texts/text.js";
import { byId, make, say } from "../util/dom.js";
import { painted } from "../util/frame-loop.js";
import { decimalOf, noNumber } from "../util/number-text.js";
import { keepOffline } from "../util/offline.js";
import { local } from "../util/storage.js";

/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { BoardList } from "../net/replies.js" */

/**
 * Runs a page; if that fails, shows why.
 * @param {(theme: Theme) => Promise<void> | void} open
 */
export async function openPage(open) {
  keepOffline();
  try {
    await painted();
    number(0); // loads how the language writes numbers, which takes long
    await open(new Theme());
  } catch (error) {
    showState("failed", t("page.failed"));
    byId("result").textContent = messageOf(error);
    // The visitor can act on a refusal by the server. Any other error is a bug: it goes to the console too.
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
 * @returns {string} link to the room where the visitor last played, or to the board's public room
 */
function tableLink(board) {
  const room = new Visited(local).room || (readBoardName(board) ? board : MAIN_ROOM);
  return room === MAIN_ROOM ? "./" : `./?${new URLSearchParams({ room })}`;
}

/**
 * The options of a list of boards: those of the house table first, then a group for each world.
 * @param {{value: string, name: string, world: string | null}[]} boards
 * @returns {HTMLElement[]} options and groups of options
 */
export function boardOptions(boards) {
  const [, ...away] = WORLDS;
  const of = (/** @type {(world: string | null) => boolean} */ fits) =>
    boards.filter(({ world }) => fits(world)).map(({ value, name }) => make("option", { value }, name));
  return [
    ...of((world) => world === null || !away.includes(world)),
    ...away.map((name) => make("optgroup", { label: worldWords(name) }, ...of((world) => world === name))),
  ];
}

/**
 * Fills the form for another drop with the server's list of boards.
 * @param {string} value the current board, as REST calls it; added to the list if it is missing
 * @param {string} name of the current board
 */
export async function fillBoards(value, name) {
  const select = byId("other-board", HTMLSelectElement);
  select.replaceChildren(make("option", { value }, name)); // until the list comes
  const { boards } = /** @type {BoardList} */ (await getJson("boards"));
  const listed = boards.map((board) => ({
    value: board.preset ? board.name : board.digest,
    name: board.preset ? board.name : `${board.name} (${board.digest.slice(0, 8)})`,
    world: board.world,
  }));
  if (!listed.some((board) => board.value === value)) listed.unshift({ value, name, world: null });
  select.replaceChildren(...boardOptions(listed));
  select.value = value;
}

/**
 * Whether a field contains a seed, which it then shows without leading zeros.
 * @param {HTMLInputElement} field @param {string} needs the message for an empty field @param {HTMLElement} [note] shows it
 */
export function holdSeed(field, needs, note = byId("other-note")) {
  const reading = readSeed(field.value);
  return hold(field, reading.ok ? reading.seed : null, note, reading.ok ? needs : reading.message);
}

/** Whether a field is empty or contains a number, which it then shows as REST takes it. @param {HTMLInputElement} field */
export function holdNumber(field) {
  const text = field.value.trim();
  return hold(field, text && decimalOf(text), byId("other-note"), noNumber(text));
}

/**
 * Puts a value into a field. If it has none, shows a message about the field, and focuses it.
 * @param {HTMLInputElement} field @param {string | null} value @param {HTMLElement} note @param {string} message
 */
function hold(field, value, note, message) {
  field.setAttribute("aria-invalid", String(value === null));
  note.hidden = value !== null;
  if (value !== null) field.value = value;
  else {
    say(note, "bad", message);
    field.focus();
  }
  return value !== null;
}

/** Makes the links to the other pages lead to this drop. @param {DropAddress} drop */
export function linkPages(drop) {
  const { hash } = window.location; // may contain the board
  const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
  const links = {
    "to-table": tableLink(drop.board), back: tableLink(drop.board),
    "to-replay": `replay.html?${search}${hash}`,
    "to-editor": hash ? `editor.html${hash}` : `editor.html?board=${drop.board}`,
  };
  for (const [id, href] of Object.entries(links)) {
    const link = byId(id, HTMLAnchorElement);
    if (!link.hasAttribute("aria-current")) link.href = href;
  }
}
