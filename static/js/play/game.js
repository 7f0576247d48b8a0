// The state of the live page: the room, the player's account, the settings on the desk, the series of balls.
// Panels read it, subscribe to its events and call its methods; no panel knows another.

import { payoutOf } from "../model/payout.js";
import { knownDrops, MINOR_UNITS, refillOf, viewOf } from "../model/player/account.js";
import { MAIN_ROOM } from "../model/presets.js";
import { seedAfter } from "../model/seed.js";
import { PACES } from "../model/table/pace.js";
import { boardWords, OWN } from "../model/worlds.js";
import { Visited } from "../model/player/visited.js";
import { t } from "../texts/text.js";
import { amount } from "../util/format.js";
import { isRecord, readStored } from "../util/stored.js";
import { Recovery } from "./account/recovery.js";
import { Self } from "./account/self.js";
import { Wallet } from "./account/wallet.js";
import { allowedStake, mostCredits, readStake } from "./desk/amounts.js";
import { FairPlay } from "./fairness/fair-play.js";
import { LOST, Room } from "./room.js";
import { choiceOf, findTable, putIntoAddress } from "./rooms.js";
import { DropSeries, sumsOf } from "./drop-series.js";
import { Store } from "./store.js";

/** @import { Odds } from "../model/odds.js" */
/** @import { Played } from "../model/player/account.js" */
/** @import { Pace } from "../model/table/pace.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Reason } from "./room.js" */
/** @import { TableChoice } from "./rooms.js" */
/** @import { Dropper, Limits } from "./drop-series.js" */

/**
 * @typedef {object} Choice the settings on the desk
 * @property {string | null} seed for practice; null where the server draws one
 * @property {number | null} aim m; null for the board's own start
 * @property {number} stake credits
 * @property {number} balls for each press of DROP
 * @property {Pace} pace
 * @property {string} fault why nothing can be dropped: what is wrong with a field; "" if nothing is
 *
 * @typedef {object} Ask what a ball is dropped with
 * @property {string | null} seed
 * @property {number | null} aim
 * @property {number} [stake] credits, instead of the stake on the desk
 */

const CHOICE_KEY = "plinko.choice.1";
const BALLS = [1, 5, 20]; // for each press

/** The store that all panels share. */
export class Game extends Store {
  /** @type {Choice} */
  choice;
  /** @type {Odds | null} of this room's board */
  odds = null;
  /** Those whose balls have not all landed yet. @type {DropSeries[]} */
  #series = [];
  #timer = 0;
  /** The main room's board, null until known. @type {string | null} */
  #mainBoard = null;
  /** Whether the player has chosen another table, which is being opened. */
  moving = false;

  /** @param {{storage: Pick<Storage, "getItem" | "setItem" | "removeItem">, solver: Solver | null, streams: string[], room: string}} options */
  constructor({ storage, solver, streams, room }) {
    super();
    this.storage = storage;
    this.solver = solver;
    this.streams = streams;
    const kept = readStored(storage, CHOICE_KEY, isChoice) ?? { stake: 1, balls: 1, pace: "real" };
    this.choice = { ...kept, seed: null, aim: null, fault: "" };
    this.wallet = new Wallet(storage);
    this.visited = new Visited(storage);
    this.self = new Self(storage);
    this.recovery = new Recovery(this.wallet, {
      onChange: () => this.tell("account", null),
      onFound: (played) => this.say(foundWords(played), { urgent: true }),
      onGone: (n) => this.say(t("play.stakes-back", { n }), { urgent: true }),
    });
    this.on("staked", (receipt) => {
      this.wallet.apply({ ...receipt, type: "staked", room: this.room.id });
      this.tell("account", null);
    });
    this.on("over", (over) => this.wallet.apply({ type: "over", room: this.room.id, ...over }));
    this.on("rejoined", ({ session, drops }) => {
      if (drops > knownDrops(this.wallet.account, session)) this.tell("behind", session);
    });
    this.on("behind", (session) => this.recovery.seek([session]));
    this.on("corrected", (correction) => {
      this.wallet.apply({ type: "corrected", ...correction });
      this.tell("account", null);
    });
    this.on("unsealed", (ref) => this.room.own.refused(ref));
    this.on("seen", (played) => this.#seen(played));
    this.on("refused", ({ ref }) => {
      for (const series of this.#series) series.refuse(ref);
      this.#finish();
      this.tell("account", null);
    });
    this.on("adopted", (balls) => this.#adopt(balls));
    this.on("halted", (halted) => {
      if (halted) this.stop("refused");
      this.say(t(halted ? "play.halted" : "play.resumed"), { urgent: true });
    });
    this.on("table", ({ hello }) => {
      if (hello.room === MAIN_ROOM) this.#mainBoard = hello.board_name;
      this.#setPace();
    });
    let there = true; // the connection
    this.on("room", () => {
      const { hello, state } = this.room;
      const lost = LOST.includes(state);
      if (lost && there) {
        if (this.busy && !hello) this.#sayRefused(); // pressed while the page was connecting
        this.stop("refused");
      }
      there = !lost;
    });
    window.addEventListener("storage", () => this.tell("account", null)); // panels then read the wallet
    this.room = this.#open(room);
  }

  /** Says what a player must know of the stored credits, once panels can show it. */
  begin() {
    if (this.wallet.damaged) this.say(t("play.damaged", { balance: amount(this.account.balance) }), { urgent: true });
  }

  /** @param {string} id */
  #open(id) {
    this.visited.enter(id);
    this.recovery.seekAllBut(id);
    this.recovery.seek(this.wallet.incomplete);
    const { streams, solver, wallet, self, storage } = this;
    return new Room(id, {
      news: this, streams, solver, wallet, self, fair: (send) => new FairPlay(id, storage, this, send),
    });
  }

  /** Enters a room at once. @param {string} id */
  enter(id) {
    if (id === this.room.id) return;
    this.stop("player");
    this.#series = [];
    this.room.close();
    this.room = this.#open(id);
    this.tell("room", null);
    this.tell("account", null);
  }

  /** Whether the table cannot be changed: staked balls of ours have not landed, or are still to be dropped. */
  get locked() {
    return this.room.own.atStake > 0 || this.#series.some(({ left, practice }) => left > 0 && !practice);
  }

  /** Moves to a board's room. Until it is found, nothing can be dropped. @param {TableChoice} choice */
  async move(choice) {
    if (this.locked || this.moving) {
      this.tell("choice", null); // panels show this room's values again
      return;
    }
    this.#setMoving(true);
    this.stop("player");
    try {
      const room = await findTable(choice, this.#mainBoard, this.visited);
      if (room !== this.room.id) {
        putIntoAddress(room);
        this.enter(room);
      }
    } catch {
      this.say(t("play.table-fails"), { urgent: true });
    } finally {
      this.#setMoving(false);
    }
  }

  /** @param {boolean} moving */
  #setMoving(moving) {
    this.moving = moving;
    this.tell("choice", null);
  }

  /** @returns {TableChoice | null} this room's board; null before it is known, and if the form does not offer it */
  get played() {
    return this.room.hello && choiceOf(this.room.hello);
  }

  /** Moves to the same triangle in another world. @param {string} world */
  travel(world) {
    const { played } = this;
    if (played) void this.move({ ...played, kind: "triangle", world, gravity: OWN, material: OWN });
  }

  /** @param {Partial<Choice>} changed */
  choose(changed) {
    Object.assign(this.choice, changed);
    const { stake, balls, pace } = this.choice;
    this.storage.setItem(CHOICE_KEY, JSON.stringify({ stake, balls, pace }));
    this.#setPace();
    this.tell("choice", null);
  }

  #setPace() {
    const { table } = this.room;
    if (table) table.pace = table.solve ? PACES[this.choice.pace] : PACES.real;
  }

  /** @returns {Reason | null} why drops are practice now; null when they are staked */
  get practice() {
    const { seed, aim } = this.choice;
    if (seed !== null) return "seed";
    return this.room.practice ?? (aim === null ? null : "aim");
  }

  /** The account as panels show it: stakes not yet answered are already deducted. */
  get account() {
    return viewOf(this.wallet.account, this.room.own.held);
  }

  /** The running auto-drop. @returns {DropSeries | null} */
  get auto() {
    return this.#series.find(({ limits, stopped }) => limits && !stopped) ?? null;
  }

  /** Whether our balls are in flight, or still to be dropped. */
  get busy() {
    return this.#series.some(({ over }) => !over);
  }

  /** @returns {number} our balls in flight */
  get falling() {
    return this.#series.reduce((sum, { falling }) => sum + falling, 0);
  }

  /** @param {number | null} [aim] m, instead of the aim set on the desk */
  drop(aim = this.choice.aim) {
    const { seed, balls } = this.choice;
    if (this.#allowed()) this.#press(balls, { seed, aim });
  }

  /** Drops one ball with an earlier one's stake. @param {Played} played */
  again({ stake }) {
    if (!this.moving) this.#press(1, { seed: null, aim: null, stake });
  }

  /** Lets an earlier ball fall once more, as practice. @param {Played} played */
  rehearse({ seed, aim = null }) {
    if (!this.moving) this.#press(1, { seed, aim });
  }

  /** @param {number} rate balls a second @param {number} count infinite for no end @param {Limits} limits */
  startAuto(rate, count, limits) {
    if (!this.#allowed()) return;
    const { seed, aim } = this.choice;
    this.#add(new DropSeries({ practice: this.practice !== null, limits }), count, { seed, aim }, rate);
  }

  /** @returns {boolean} whether the settings on the desk can be dropped with; panels say why not */
  #allowed() {
    if (this.choice.fault) this.tell("faulty", null);
    return !this.choice.fault && !this.moving;
  }

  /** @param {number} balls @param {Ask} ask */
  #press(balls, ask) {
    const practice = ask.seed !== null || ask.aim !== null || this.room.practice !== null;
    const going = this.#series.find((series) => !series.limits && series.practice === practice);
    this.#add(going ?? new DropSeries({ practice }), balls, ask);
  }

  /** @param {DropSeries} series @param {number} balls @param {Ask} ask @param {number} [rate] a second */
  #add(series, balls, ask, rate) {
    if (!this.#series.includes(series)) this.#series.push(series);
    series.add(balls, this.#dropper(series, ask), performance.now(), rate);
    this.#pump();
  }

  /** Counts balls that were in flight before this page was loaded. @param {{ref: string, stake: number}[]} balls */
  #adopt(balls) {
    const series = new DropSeries();
    for (const ball of balls) series.adopt(ball);
    this.#series.push(series);
    this.say(t("play.adopted", { n: balls.length }), { urgent: true });
    this.tell("run", null);
  }

  /** Stops dropping; balls in flight still count. @param {"player" | "refused"} why */
  stop(why) {
    for (const series of this.#series) series.stop(why);
    this.#finish();
  }

  /** The largest stake at this table, credits. */
  get mostStake() {
    return mostCredits(this.room.hello?.board.bins.multipliers ?? null);
  }

  /** @param {DropSeries} series @param {Ask} ask @returns {Dropper} */
  #dropper(series, { seed, aim, stake }) {
    let next = seed;
    const practice = () => next !== null || aim !== null || this.room.practice !== null;
    return {
      stake: () => (practice() ? 0 : stake ?? allowedStake(this.choice.stake * series.factor, this.mostStake)),
      drop: (due) => {
        // Where practice begins or ends, the player decides whether to go on.
        if (series.practice !== practice()) return series.practice ? "player" : "refused";
        if (due > this.account.balance) {
          this.say(t("play.too-few"), { urgent: true });
          return "credits";
        }
        const ref = this.room.drop({ seed: next, aim, stake: due });
        if (ref === null) {
          this.#sayRefused();
          return "refused";
        }
        if (next !== null) next = seedAfter(next);
        this.tell("account", null);
        return { ref, stake: due };
      },
    };
  }

  #sayRefused() {
    this.say(t(this.room.state === "full" ? "play.full" : "play.no-line"), { urgent: true });
  }

  #pump() {
    clearTimeout(this.#timer);
    const now = performance.now();
    const wait = Math.min(...this.#series.map((series) => series.give(now, () => this.room.hasRoom)));
    if (Number.isFinite(wait)) this.#pumpIn(Math.max(4, wait));
    this.#finish();
  }

  /** @param {number} ms */
  #pumpIn(ms) {
    clearTimeout(this.#timer);
    this.#timer = window.setTimeout(() => this.#pump(), ms);
  }

  /** Books a drop whose landing was shown, in every panel at once. @param {Played} played */
  #seen(played) {
    const { fair, stake, score, practice } = played;
    const payout = payoutOf(Math.round(stake * MINOR_UNITS), score);
    if (fair) this.wallet.apply({ type: "settled", ...fair, payout, played });
    else if (practice) this.wallet.apply({ type: "practised", played });
    for (const series of this.#series) if (series.land(played)) break;
    this.tell("account", null);
    // The limits of a series may have waited for this landing. Not at once: a room that is being entered can take no drop yet.
    this.#pumpIn(0);
    this.#finish();
  }

  /** Reports the series whose balls have all landed. */
  #finish() {
    const over = this.#series.filter((series) => series.over);
    this.#series = this.#series.filter((series) => !series.over);
    for (const series of over) {
      const words = series.words();
      if (words) this.say(words.text, { score: words.score, urgent: series.limits !== null });
    }
    this.tell("run", null);
  }

  refill() {
    const before = this.account.balance;
    this.wallet.apply(refillOf(this.wallet.account));
    this.tell("account", null);
    this.say(t("play.refilled", { added: amount(this.account.balance - before) }), { urgent: true });
  }

  /** Clears statistics and history; the balance stays. */
  reset() {
    this.wallet.apply({ type: "reset" });
    this.tell("account", null);
  }
}

/** @param {Played[]} played drops of one session, found after an absence @returns {string} */
function foundWords(played) {
  const [{ name }] = played;
  const staked = played.reduce((sum, { stake }) => sum + stake, 0);
  const paid = played.reduce((sum, one) => sum + one.paid, 0);
  return t("play.found", { n: played.length, board: boardWords(name), ...sumsOf({ staked, paid }) });
}

/** @param {unknown} value @returns {value is Pick<Choice, "stake" | "balls" | "pace">} */
function isChoice(value) {
  return isRecord(value) && readStake(String(value.stake)) === value.stake && BALLS.includes(Number(value.balls))
    && Object.hasOwn(PACES, String(value.pace));
}
