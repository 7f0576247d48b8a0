// The room's show beside the board: its logo, timer, jackpot and goals, in the colours and the font of the show.

import { getJson } from "../net/api.js";
import { byId, make } from "../util/dom.js";
import { plain } from "../util/format.js";
import { Faces } from "./faces.js";

/** @import { Goal, Looks, Show, ShowReply } from "../net/replies.js" */

const AGAIN_MS = 5000; // until the next request, if one failed
/** The styles of the page that the looks of a show replace. @type {[string, Exclude<keyof Looks, "logo">][]} */
const STYLES = [
  ["--case", "panel"], ["--case-shade", "panel"], ["--ink", "ink"], ["--accent", "accent"], ["--show-font", "font"],
];

/** @param {number} seconds @returns {string} "2:03:04", "3:04" */
export function clock(seconds) {
  const whole = Math.ceil(Math.max(0, seconds));
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const [first, ...rest] = parts[0] ? parts : parts.slice(1);
  return [first, ...rest.map((part) => String(part).padStart(2, "0"))].join(":");
}

/** Loads the show whenever it changes, and counts its timer down. */
export class Figures {
  faces = new Faces();
  #loading = false;
  #stale = false;
  /** Local time at which the timer has run out, ms. */
  #endMs = 0;
  #turn = 0;

  /** @param {string} room */
  constructor(room) {
    this.path = `rooms/${encodeURIComponent(room)}/show`;
  }

  /** Fetches the show; what changes meanwhile is fetched after it. */
  async load() {
    this.#stale = true;
    if (this.#loading) return;
    this.#loading = true;
    try {
      while (this.#stale) {
        this.#stale = false;
        const { age, show } = /** @type {ShowReply} */ (await getJson(this.path));
        this.#set(show, age);
      }
    } catch {
      window.setTimeout(() => void this.load(), AGAIN_MS); // a room without a server says so itself
    } finally {
      this.#loading = false;
    }
  }

  /** @param {Show} show @param {number} age s */
  #set({ timer, jackpot, goals = [], looks = {}, faces = {} }, age) {
    this.faces.set(faces);
    const values = { ...looks, font: looks.font ? `"${looks.font}"` : null };
    for (const [name, look] of STYLES) document.documentElement.style.setProperty(name, values[look] ?? "");
    const logo = byId("logo", HTMLImageElement);
    logo.hidden = !looks.logo;
    if (looks.logo && logo.src !== looks.logo) logo.src = looks.logo;
    put("timer", timer?.label, timer ? "" : null);
    put("jackpot", jackpot?.label, jackpot ? `${plain(jackpot.value)}${jackpot.unit ?? ""}` : null);
    byId("goals").replaceChildren(...goals.map(bar));
    byId("figures").hidden = !looks.logo && !timer && !jackpot && !goals.length;
    window.clearTimeout(this.#turn);
    if (!timer) return;
    const running = timer.running ?? true;
    this.#endMs = performance.now() + 1000 * (timer.left - (running ? age : 0));
    byId("timer").dataset.paused = String(!running);
    this.#count(running);
  }

  /** Shows the time left, and again when the next second begins. @param {boolean} running */
  #count(running) {
    const left = Math.max(0, this.#endMs - performance.now());
    byId("timer-value").textContent = clock(left / 1000);
    if (running && left) this.#turn = window.setTimeout(() => this.#count(true), (left - 1) % 1000 + 1);
  }
}

/** @param {"timer" | "jackpot"} id @param {string | undefined} label @param {string | null} value null hides it */
function put(id, label, value) {
  byId(id).hidden = value === null;
  byId(`${id}-label`).textContent = label ?? "";
  if (value !== null) byId(`${id}-value`).textContent = value;
}

/** @param {Goal} goal @returns {HTMLElement} */
function bar({ label, value, target }) {
  const filled = make("i", {});
  filled.style.width = `${100 * Math.min(1, Math.max(0, value / target))}%`;
  return make("li", {}, make("bdi", {}, label ?? ""), make("b", {}, `${plain(value)} / ${plain(target)}`),
    make("span", { class: "bar" }, filled));
}
