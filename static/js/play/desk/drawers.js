// The sheet behind "More": one drawer open at a time. Beside the board, "Game" stands where no other is open;
// below it the sheet lies over the board.

import { byId, isWithin } from "../../util/dom.js";

/** @import { Game } from "../game.js" */

const KEYS = new Map([["g", "game"], ["t", "table"], ["f", "fair"], ["l", "lab"], ["s", "settings"]]);
const KEPT = "plinko.drawer.1"; // over a change of language
const TYPED_INTO = "input:not([type=range], [type=radio], [type=checkbox]), select, textarea";

/** Opens and closes drawers. */
export class Drawers {
  /** @type {string | null} */
  open = null;

  /** @param {Game} game */
  constructor(game) {
    this.box = byId("sheet");
    this.tabs = [...this.box.querySelectorAll("[aria-controls]")];
    this.more = byId("more");
    this.padlock = byId("padlock");
    this.keys = byId("keys", HTMLDialogElement);
    this.wide = window.matchMedia("(min-aspect-ratio: 11/10) and (min-width: 40rem)");
    this.wide.addEventListener("change", () => this.show(this.open));
    for (const tab of this.tabs) tab.addEventListener("click", () => this.show(drawerOf(tab)));
    this.more.addEventListener("click", () => this.show(this.open ? null : this.#first));
    this.padlock.addEventListener("click", () => this.show(this.open === "fair" ? null : "fair"));
    byId("sheet-close").addEventListener("click", () => this.#close());
    byId("world-key").addEventListener("click", () => this.show(this.open === "table" ? null : "table"));
    byId("keys-open").addEventListener("click", () => this.keys.showModal());
    document.addEventListener("keydown", (event) => this.#key(event));
    // What is wrong with a seed is read where the seed is.
    game.on("choice", () => { if (byId("seed").getAttribute("aria-invalid") === "true") this.show("lab"); });
    game.on("table", ({ hello }) => { byId("keys-aim").hidden = hello.slots.length === 0 && byId("start").hidden; });
    this.show(window.sessionStorage.getItem(KEPT));
  }

  get #first() {
    return this.wide.matches ? "table" : "game";
  }

  /** @param {string | null} name of a drawer, or null to close what is open */
  show(name) {
    this.open = name === "game" && this.wide.matches ? null : name;
    const shown = this.open ?? (this.wide.matches ? "game" : null);
    document.documentElement.dataset.drawer = this.open ?? "";
    if (this.open) window.sessionStorage.setItem(KEPT, this.open);
    else window.sessionStorage.removeItem(KEPT);
    this.more.setAttribute("aria-expanded", String(this.open !== null));
    this.padlock.setAttribute("aria-expanded", String(this.open === "fair"));
    this.box.hidden = shown === null;
    for (const tab of this.tabs) {
      const drawer = drawerOf(tab);
      tab.setAttribute("aria-expanded", String(drawer === shown));
      byId(drawer).hidden = drawer !== shown;
    }
    byId("sheet-body").scrollTop = 0;
  }

  #close() {
    this.show(null);
    this.more.focus();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.keys.open) return;
    if (event.key === "Escape" && this.open) this.#close();
    if (isWithin(event, TYPED_INTO)) return;
    const drawer = KEYS.get(event.key.toLowerCase());
    if (drawer) this.show(this.open === drawer ? null : drawer);
    else if (event.key === "m" || event.key === "M") byId("sound").click();
    else if (event.key === "?") this.keys.showModal();
  }
}

/** @param {Element} tab @returns {string} the id of the drawer that it opens */
function drawerOf(tab) {
  return tab.getAttribute("aria-controls") ?? "";
}
