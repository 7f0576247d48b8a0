// Demo balls: they fall in a quiet room, only in this page, until somebody plays. They are neither counted nor sent.

import { randomSeed } from "../../model/seed.js";
import { byId } from "../../util/dom.js";

/** @import { Hello } from "../../model/messages.js" */
/** @import { Scene } from "../../model/scene.js" */
/** @import { Solve } from "../../model/table/table.js" */
/** @import { Table } from "../../model/table/table.js" */
/** @import { Game } from "../game.js" */
/** @import { DemoBalls } from "./demo-balls.js" */

const KEY = "plinko.demo.1";
const QUIET_MS = 5000; // before the first ball

/**
 * Begins in a room that stays quiet, and ends for good in that room with anybody's first ball.
 * @param {Game} game
 * @returns {(nowMs: number, table: Table | null, still: boolean) => Scene | null} null while there is no demo;
 *   table: the real one; still: whether motion is reduced
 */
export function offerDemo(game) {
  const wanted = byId("demo", HTMLInputElement);
  /** @type {DemoBalls | null} */
  let balls = null;
  let timer = 0;
  let digest = "";
  /** Starts waiting for a quiet time; null once somebody has played. @type {(() => void) | null} */
  let wait = null;

  const hide = () => {
    window.clearTimeout(timer);
    balls = null;
    byId("demo-mark").hidden = true;
  };
  const end = () => {
    wait = null;
    hide();
  };
  /** @param {Hello} hello @param {Solve} solve */
  const begin = async (hello, solve) => {
    if (!wanted.checked || document.visibilityState === "hidden") return;
    const begun = wait;
    const code = await import("./demo-balls.js").catch(() => null);
    if (!code || wait !== begun || !wanted.checked) return; // cannot be fetched, or somebody has played meanwhile
    balls = new code.DemoBalls(hello, solve, randomSeed);
    byId("demo-mark").hidden = false;
    game.tell("picture", null);
  };
  wanted.checked = game.storage.getItem(KEY) !== "off";
  wanted.addEventListener("change", () => {
    game.storage.setItem(KEY, wanted.checked ? "on" : "off");
    if (wanted.checked) wait?.();
    else hide();
  });
  game.on("table", ({ hello, table: { solve, flying } }) => {
    if (hello.board_digest === digest) return; // a reconnect
    digest = hello.board_digest;
    end();
    if (!solve || flying) return;
    wait = () => {
      window.clearTimeout(timer);
      timer = window.setTimeout(() => begin(hello, solve), QUIET_MS);
    };
    wait();
  });
  return (nowMs, table, still) => {
    if ((wait || balls) && (table?.flying || still)) end();
    const scene = balls?.sceneAt(nowMs) ?? null;
    if (balls && !scene) end();
    return scene;
  };
}
