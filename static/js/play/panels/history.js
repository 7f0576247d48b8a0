// The history: the last drops as chips next to the board, which lead to their replays, and all kept drops as a list.

import { boardWords } from "../../model/worlds.js";
import { replayLink } from "../../net/drop-address.js";
import { t } from "../../texts/text.js";
import { byId, make } from "../../util/dom.js";
import { amount, shortSeed, signed } from "../../util/format.js";
import { Prover } from "../fairness/proof.js";
import { paidMark } from "./list-marks.js";

/** @import { Played } from "../../model/player/account.js" */
/** @import { Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const CHIPS = 12; // the style sheet hides some where space is short
const RENEWED_MS = 200; // between two updates while many balls land

/** @param {Game} game @param {Theme} theme */
export function showHistory(game, theme) {
  const prover = new Prover(game);
  /** By drop; reused, as a row may show its proof. @type {Map<string, {line: HTMLElement, chip: HTMLElement}>} */
  let rows = new Map();
  let newest = "";

  const show = () => {
    const { last } = game.account;
    byId("history-empty").hidden = last.length > 0;
    const here = game.room.hello?.board_digest;
    const keys = last.map((drop) => JSON.stringify([drop, drop.boardDigest === here]));
    rows = new Map(keys.map((key, i) => [key, rows.get(key) ?? { line: row(last[i]), chip: chip(last[i]) }]));
    byId("drops").replaceChildren(...[...rows.values()].map(({ line }) => line));
    const fresh = newest !== "" && keys.length > 0 && keys[0] !== newest;
    newest = keys[0] ?? " ";
    const chips = [...rows.values()].slice(0, CHIPS).map((each) => each.chip);
    chips.forEach((each, i) => each.classList.toggle("fresh", fresh && i === 0));
    byId("last").replaceChildren(...chips);
  };

  /** @param {Played} drop @returns {HTMLElement} its multiplier, or that it did not land in a bin */
  const mark = ({ bin, score }) => {
    const paid = paidMark(theme, null, bin, score);
    if (bin === null) paid.title = t("play.void-why");
    return paid;
  };

  /** @param {Played} drop */
  const chip = (drop) => make("li", {}, drop.knocked
    ? mark(drop) : make("a", { href: replayLink(drop), title: t("play.replay") }, mark(drop)));

  /** @param {Played} drop */
  const row = (drop) => {
    const { seed, practice, stake, paid } = drop;
    const board = boardWords(drop.name);
    const where = practice || drop.x !== null
      ? [make("span", { class: "on" }, t("practice.word"))]
      : [make("b", { class: "net" }, signed(paid - stake)), make("span", { class: "on of-board" }, board)];
    const line = make("li", {}, mark(drop), ...where);
    if (drop.knocked) {
      // A ball that others knocked cannot be replayed from its seed.
      line.append(make("span", { class: "on" }, t("play.knocked")));
      return line;
    }
    if (prover.canVerify(drop)) {
      line.append(key("play.verify", t("play.verify-seed", { seed, board }), () => prover.show(drop, line)));
    }
    const name = t("play.replay-seed", { seed, board });
    line.append(make("a", { class: "again", href: replayLink(drop), "aria-label": name }, t("play.replay")));
    if (drop.boardDigest !== game.room.hello?.board_digest) return line; // these drop onto this board
    if (!practice) {
      line.append(key("play.again", t("play.again-for", { stake: amount(stake) }), () => game.again(drop)));
    }
    const repeat = key("play.use-seed", t("play.use-seed-again", { seed: shortSeed(seed) }), () => game.rehearse(drop));
    repeat.classList.add("use-seed");
    line.append(repeat);
    return line;
  };

  for (const kind of /** @type {const} */ (["account", "table"])) game.onCalm(kind, RENEWED_MS, show);
  theme.onChange(() => {
    rows.clear();
    show();
  });
  show();
}

/** @param {"play.verify" | "play.again" | "play.use-seed"} text @param {string} name @param {() => void} press */
function key(text, name, press) {
  const button = make("button", { class: "verify", type: "button", "aria-label": name, title: name }, t(text));
  button.addEventListener("click", press);
  return button;
}
