// What this browser stores for the pages. Every page reads and writes through here.
//
// A browser may refuse: a visitor can block storage (then even `window.localStorage` throws, or is null), and a full
// disk or quota refuses writes. The values of refused writes stay in memory until the browser takes them, so that the
// page works as usual. The first refused write tells the visitor so.

import { t } from "../texts/text.js";
import { make } from "./dom.js";

/** A Storage that never throws. */
export class SafeStorage {
  /** Values that the browser refused to store; null: refused to remove. @type {Map<string, string | null>} */
  #memory = new Map();

  /**
   * @param {() => Storage} open returns the browser's storage, or throws
   * @param {() => void} onRefused called after each write that only the memory keeps
   */
  constructor(open, onRefused) {
    this.open = open;
    this.onRefused = onRefused;
  }

  /** @param {string} key @returns {string | null} */
  getItem(key) {
    const unstored = this.#memory.get(key);
    // What the browser has refused it may take now; until then each tab has values of its own.
    if (unstored !== undefined && !this.#store()) return unstored;
    try {
      return this.open().getItem(key);
    } catch {
      return null; // what is blocked is as good as empty
    }
  }

  /** @param {string} key @param {string} value @returns {boolean} whether the browser has stored it */
  setItem(key, value) {
    this.#memory.set(key, value);
    if (this.#store()) return true;
    this.onRefused();
    return false;
  }

  /** Stores what the memory has, with what was refused before. @returns {boolean} whether the browser has taken all */
  #store() {
    try {
      const storage = this.open();
      for (const [key, value] of this.#memory) {
        if (value === null) storage.removeItem(key);
        else storage.setItem(key, value);
        this.#memory.delete(key);
      }
      return true;
    } catch {
      return false; // the memory still has it
    }
  }

  /** @param {string} key */
  removeItem(key) {
    this.#memory.set(key, null);
    this.#store();
  }
}

let noticed = false;

/** Tells the visitor once that nothing is stored. */
function notice() {
  if (noticed) return;
  noticed = true;
  const close = make("button", { type: "button", class: "small" }, t("page.close"));
  const panel = make("aside", { class: "unstored", role: "alert" }, make("p", {}, t("page.unstored")), close);
  close.addEventListener("click", () => panel.remove());
  document.body.append(panel);
}

/** Shared by all tabs of this browser. */
export const local = new SafeStorage(() => window.localStorage, notice);
/** Of this tab only. */
export const tab = new SafeStorage(() => window.sessionStorage, notice);
