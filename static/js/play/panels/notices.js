// The page's messages: the status line, the connection's state, and a button out of a room that is gone.

import { MAIN_ROOM } from "../../model/presets.js";
import { t } from "../../texts/text.js";
import { byId, onClick, putMessage } from "../../util/dom.js";
import { LOST } from "../room.js";
import { putIntoAddress } from "../rooms.js";

/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const STATES = /** @type {const} */ ({
  connecting: "play.connecting", live: "play.live", asleep: "play.ready", closed: "play.closed",
  reconnecting: "play.reconnecting", full: "play.full-state",
});

/**
 * The status line shows results, and between them how many balls fall.
 * @param {Game} game @param {Theme} theme
 * @returns {() => void} called for each frame: says how many balls fall, if that has changed
 */
export function showNotices(game, theme) {
  /** Whether the shown message stays while a ball falls. */
  let stays = false;
  let told = "";
  const line = byId("result");
  const connecting = line.textContent;
  let before = game.room.state;

  /** @param {string} text @param {number} [score] */
  const put = (text, score) => {
    putMessage(line, text);
    line.style.setProperty("--paid", score === undefined ? "transparent" : theme.payout(score).fill);
  };
  /** @param {string} text @param {boolean} urgent @param {number} [score] */
  const say = (text, urgent, score) => {
    stays = urgent && game.busy;
    put(text, score);
  };
  const showState = () => {
    const { state, wait, hello } = game.room;
    document.documentElement.dataset.state = state;
    byId("state-text").textContent = t(STATES[state], { n: wait });
    byId("gone").hidden = state !== "closed";
    byId("gone-words").textContent = state === "closed" ? t(hello ? "play.table-closed" : "play.table-gone") : "";
    byId("line-key").hidden = state !== "reconnecting" && state !== "full";
    if (state === "reconnecting" && before !== state) say(t("play.line-broke"), true);
    if (state === "full" && before !== state) say(t("play.full"), true);
    if (LOST.includes(before) && !LOST.includes(state)) say(t("play.back"), true);
    // Nothing else has been said since the page was opened.
    if (before === "connecting" && state !== before && line.textContent === connecting) {
      put(state === "closed" ? "" : t("play.first"));
    }
    before = state;
  };
  game.on("said", ({ text, score, urgent = false }) => say(text, urgent, score));
  game.on("table", () => { stays = false; });
  /** @param {string | null} text */
  const announce = (text) => {
    byId("notice").hidden = !text;
    byId("notice").textContent = text;
  };
  game.on("table", () => announce(null)); // a hello; an announcement follows it
  game.on("notice", ({ text, leaving }) => announce(leaving ? t("play.leaving") : text));
  game.on("room", showState);
  onClick("line-key", () => game.room.connection.retryNow());
  onClick("gone-key", () => { // leads from a room that is gone to the main room
    putIntoAddress(MAIN_ROOM);
    if (game.room.id === MAIN_ROOM) window.location.reload();
    else game.enter(MAIN_ROOM);
  });
  showState();
  return () => {
    const n = game.falling;
    const words = n > 1 ? t("play.balls-fall", { n }) : n === 1 ? t("play.falls") : "";
    if (words && !stays && words !== told) put(words);
    told = words;
  };
}
