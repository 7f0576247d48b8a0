// The sheet behind "More", with one drawer open at a time. On a wide screen the sheet is next to the board, and shows
// "Game" while no other drawer is open; on a narrow or low one it covers the board.

import { hasServer } from "../../net/ask.js";
import { byId, onClick } from "../../util/dom.js";
import { tab } from "../../util/storage.js";
import { onKey } from "./keys.js";

/** @import { Game } from "../game.js" */

const KEYS = { g: "game", t: "table", l: "lab", s: "settings", ...(hasServer && { f: "fair" }) };
const KEPT = "plinko.drawer.1"; // the open drawer survives the reload that changes the language
const ENTRY = "drawer"; // in the state of the history's entry
const SWIPE = 50; // CSS pixels, more up or down than sideways

/**
 * Opens and closes drawers.
 * @param {Game} game @param {(drawer: string) => Promise<boolean>} load loads what a drawer needs, and returns whether it could
 */
export function offerDrawers(game, load) {
  const tabs = [...byId("sheet").querySelectorAll("[aria-controls]")];
  const more = byId("more");
  const keys = byId("keys", HTMLDialogElement);
  const wide = window.matchMedia("(min-aspect-ratio: 11/10) and (min-width: 35rem) and (not (max-height: 34rem))");
  /** @type {string | null} */
  let open = null;
  let begun = false;
  /** Whether the browser's Back closes the drawer: it has an entry of its own in the history. */
  const hasEntry = () => window.history.state?.[ENTRY] === true;

  /** @param {string | null} name of the drawer to open; null closes the open one */
  const show = (name) => {
    open = name === "game" && wide.matches ? null : name;
    const shown = open ?? (wide.matches ? "game" : null);
    document.documentElement.dataset.drawer = open ?? "";
    if (open) tab.setItem(KEPT, open);
    else tab.removeItem(KEPT);
    more.setAttribute("aria-expanded", String(open !== null));
    byId("padlock").setAttribute("aria-expanded", String(open === "fair"));
    byId("sheet").hidden = shown === null;
    for (const each of tabs) {
      const drawer = drawerOf(each);
      each.setAttribute("aria-expanded", String(drawer === shown));
      byId(drawer).hidden = drawer !== shown;
    }
    if (begun) byId("sheet-body").scrollTop = 0; // at the start nothing is scrolled, and this costs a layout
    begun = true;
    // Where a drawer covers the board, Back leads to the board.
    if (open && !wide.matches && !hasEntry()) window.history.pushState({ [ENTRY]: true }, "");
    else if (!open && hasEntry()) window.history.back();
  };
  let wanted = ""; // the drawer asked for last: another may load longer
  /** @param {string} drawer */
  const pull = async (drawer) => {
    wanted = drawer;
    if (await load(drawer) && wanted === drawer) show(drawer);
  };
  /** Opens a drawer, or closes it if it is open. @param {string} drawer */
  const turn = (drawer) => (open === drawer ? show(null) : void pull(drawer));
  const close = () => {
    show(null);
    more.focus();
  };

  wide.addEventListener("change", () => show(open));
  window.addEventListener("popstate", () => { if (open && !hasEntry()) show(null); });
  for (const each of tabs) each.addEventListener("click", () => pull(drawerOf(each)));
  onClick("more", () => (open ? show(null) : void pull(wide.matches ? "table" : "game")));
  onClick("padlock", () => turn("fair"));
  onClick("world-key", () => turn("table"));
  onClick("sheet-close", close);
  onClick("keys-open", () => keys.showModal());
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && open && !keys.open) close();
  });
  for (const [key, drawer] of Object.entries(KEYS)) onKey([key], () => turn(drawer));
  onKey(["m"], () => byId("sound").click());
  onKey(["?"], () => keys.showModal());
  // On a narrow screen a swipe up opens the game's figures, and a swipe down at their top closes them.
  /** @type {Touch | null} */
  let from = null;
  document.addEventListener("touchstart", ({ touches }) => {
    from = touches.length === 1 && (!open || byId("sheet-body").scrollTop === 0) ? touches[0] : null;
  }, { passive: true });
  document.addEventListener("touchend", ({ changedTouches: [to] }) => {
    if (!from || wide.matches) return;
    const up = from.clientY - to.clientY;
    if (Math.abs(up) < Math.max(SWIPE, 2 * Math.abs(from.clientX - to.clientX))) return;
    if (!open && up > 0) show("game");
    else if (open && up < 0) show(null);
  });
  // The drawer "Lab" has the seed field, and the message about an invalid seed.
  game.on("choice", () => { if (byId("seed").getAttribute("aria-invalid") === "true") void pull("lab"); });
  game.on("table", ({ hello }) => { byId("keys-aim").hidden = hello.slots.length === 0 && byId("start").hidden; });
  const kept = tab.getItem(KEPT);
  show(null);
  if (kept) void pull(kept);
}

/** @param {Element} tab @returns {string} the id of the drawer that it opens */
function drawerOf(tab) {
  return tab.getAttribute("aria-controls") ?? "";
}
