// The drawers behind "More": Table, Fairness, Lab, Settings, one open at a time; and the sheet of keys.

import { byId, isWithin } from "../../util/dom.js";

const KEYS = new Map([["t", "table"], ["f", "fair"], ["l", "lab"], ["s", "settings"]]);

/** Opens and closes drawers. The board stays in view: a drawer takes the room of what lies in the well. */
export class Drawers {
  constructor() {
    this.box = byId("drawers");
    this.tabs = [...this.box.querySelectorAll(".drawer-tab")];
    this.more = byId("more");
    this.padlock = byId("padlock");
    this.sheet = byId("keys", HTMLDialogElement);
    this.open = null;
    for (const tab of this.tabs) tab.addEventListener("click", () => this.show(drawerOf(tab)));
    this.more.addEventListener("click", () => this.show(this.open ? null : "table"));
    this.padlock.addEventListener("click", () => this.show(this.open === "fair" ? null : "fair"));
    byId("keys-open").addEventListener("click", () => this.sheet.showModal());
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {string | null} name of a drawer, or null to close what is open */
  show(name) {
    /** @type {string | null} */
    this.open = name;
    this.box.hidden = name === null;
    this.more.setAttribute("aria-expanded", String(name !== null));
    this.padlock.setAttribute("aria-expanded", String(name === "fair"));
    for (const tab of this.tabs) {
      const mine = drawerOf(tab);
      tab.setAttribute("aria-expanded", String(mine === name));
      byId(mine).hidden = mine !== name;
    }
    // Closed, a drawer leaves in view what is played with.
    (name === null ? byId("drop-form") : this.box).scrollIntoView({ block: "start" });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.sheet.open) return;
    if (isWithin(event, "input:not([type=range], [type=radio], [type=checkbox]), select, textarea")) return;
    const drawer = KEYS.get(event.key.toLowerCase());
    if (drawer) this.show(this.open === drawer ? null : drawer);
    else if (event.key === "m" || event.key === "M") byId("sound").click();
    else if (event.key === "?") this.sheet.showModal();
    else if (event.key === "Escape" && this.open) {
      this.show(null);
      this.more.focus();
    }
  }
}

/** @param {Element} tab @returns {string} the id of the drawer that it opens */
function drawerOf(tab) {
  return tab.getAttribute("aria-controls") ?? "";
}
