// What the pages that look at drops share: start-up, failures in words, links, the form's board list.

import { ApiError, getJson } from "../net/api.js";
import { LinkError } from "../net/board-link.js";
import { byId, make } from "../util/dom.js";
import { MAIN_ROOM, readBoardName } from "../model/presets.js";
import { Session } from "../model/session.js";
import { Theme } from "../paint/theme.js";

/** Nothing was asked for: something that shows what the page can do. */
export const DEFAULT_BOARD = "triangle-12";

/**
 * Runs a page and shows what stops it.
 * @param {(theme: Theme) => Promise<void>} open
 */
export async function openPage(open) {
  try {
    await open(await Theme.load());
  } catch (error) {
    showState("failed", "Failed");
    byId("result").textContent = error.message;
    // A refusal by the server is told to the visitor; anything else is a fault to be seen.
    if (!(error instanceof ApiError || error instanceof LinkError)) throw error;
  }
}

/** @param {string} state @param {string} words */
export function showState(state, words) {
  document.documentElement.dataset.state = state;
  byId("state-text").textContent = words;
}

/** Link back to where the visitor played, or else to this board's own table. */
export function tableLink(board) {
  const room = new Session(window.sessionStorage).room || (readBoardName(board) ? board : MAIN_ROOM);
  return room === MAIN_ROOM ? "./" : `./?${new URLSearchParams({ room })}`;
}

/**
 * Fills a select with the boards the server knows.
 * @param {HTMLSelectElement} select
 * @param {{value: string, name: string}} chosen listed even if the server's list lacks it
 */
export async function fillBoards(select, chosen) {
  const { boards } = await getJson("boards");
  const listed = boards.map(({ preset, name, digest }) => ({
    value: preset ? name : digest,
    name: preset ? name : `${name} (${digest.slice(0, 8)})`,
  }));
  if (!listed.some(({ value }) => value === chosen.value)) listed.unshift(chosen);
  select.replaceChildren(...listed.map(({ value, name }) => make("option", { value }, name)));
  select.value = chosen.value;
}

/** Lets the visitor keep a text as a file. */
export function saveFile(name, text, type) {
  const url = URL.createObjectURL(new Blob([text], { type }));
  const link = make("a", { href: url, download: name });
  link.click();
  // The browser has begun to read it; the address is not needed again.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/**
 * Rows of a definition list.
 * @param {HTMLElement} list
 * @param {[string, string | Node | (string | Node)[]][]} facts name and value
 */
export function fillFacts(list, facts) {
  list.replaceChildren(...facts.map(([name, value]) => {
    const data = make("dd", {}, ...(Array.isArray(value) ? value : [value]));
    data.dataset.fact = name.toLowerCase().replace(/ /g, "-");
    return make("div", {}, make("dt", {}, name), data);
  }));
}
