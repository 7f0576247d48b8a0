// The state of the live page: the room, the player's account, the settings on the desk, the runs of balls.
// Panels read it, subscribe to its events and call its methods; no panel knows another.

import { payoutOf } from "../model/payout.js";
import { knownDrops, MINOR_UNITS, refillOf, viewOf } from "../model/player/account.js";
import { MAIN_ROOM } from "../model/presets.js";
import { seedAfter } from "../model/seed.js";
import { PACES } from "../model/table/pace.js";
import { Visited } from "../model/player/visited.js";
import { t } from "../texts/text.js";
import { amount, plain, signed } from "../util/format.js";
import { Recovery } from "./account/recovery.js";
import { Self } from "./account/self.js";
import { Wallet } from "./account/wallet.js";
import { FairPlay } from "./fairness/fair-play.js";
import { Room } from "./room.js";
import { choiceOf, findTable, putIntoAddress } from "./rooms.js";
import { Run } from "./runs.js";
import { Store } from "./store.js";

/** @import { Odds } from "../model/odds.js" */
/** @import { Played } from "../model/player/account.js" */
/** @import { Pace } from "../model/table/pace.js" */
/** @import { World } from "../model/worlds.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Reason } from "./room.js" */
/** @import { TableChoice } from "./rooms.js" */

/**
 * @typedef {object} Choice the settings on the desk
 * @property {string | null} seed for practice; null where the server draws one
 * @property {number | null} aim m; null for the board's own start
 * @property {number} stake credits
 * @property {number} balls for each press of DROP
 * @property {Pace} pace
 */

const CHOICE_KEY = "plinko.choice.1";

/** The store that all panels share. */
export class Game extends Store {
  /** @type {Choice} */
  choice;
  /** @type {Odds | null} of this room's board */
  odds = null;
  /** Runs of balls that have not all landed yet. @type {Run[]} */
  #runs = [];
  #timer = 0;
  /** The main room's board, null until known. @type {string | null} */
  #mainBoard = null;
  /** The table to move to once our balls have landed. @type {TableChoice | null} */
  moving = null;

  /** @param {{storage: Pick<Storage, "getItem" | "setItem">, solver: Solver | null, streams: string[], room: string}} options */
  constructor({ storage, solver, streams, room }) {
    super();
    this.storage = storage;
    this.solver = solver;
    this.streams = streams;
    this.choice = {
      stake: 1, balls: 1, pace: "real", ...JSON.parse(storage.getItem(CHOICE_KEY) ?? "{}"), seed: null, aim: null,
    };
    this.wallet = new Wallet(storage);
    this.visited = new Visited(storage);
    this.self = new Self(storage);
    this.recovery = new Recovery(this.wallet, {
      onChange: () => this.tell("account", null),
      onFound: (played) => this.say(foundWords(played), { urgent: true }),
      onGone: (n) => this.say(t("play.stakes-back", { n }), { urgent: true }),
    });
    this.on("staked", ({ session, drop, stake, ball, seed }) => {
      this.wallet.apply({ type: "staked", session, drop, stake, room: this.room.id, ball, seed });
      this.tell("account", null);
    });
    this.on("over", (over) => this.wallet.apply({ type: "over", ...over }));
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
      for (const run of this.#runs) run.refuse(ref);
      this.#finish();
      this.tell("account", null);
    });
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
      const { state } = this.room;
      const lost = state === "reconnecting" || state === "closed";
      if (lost && there) this.stop("refused");
      there = !lost;
    });
    window.addEventListener("storage", () => this.tell("account", null));
    this.room = this.#open(room);
  }

  /** @param {string} id */
  #open(id) {
    this.visited.enter(id);
    this.recovery.seekAllBut(id);
    const { streams, solver, wallet, self, storage } = this;
    return new Room(id, {
      news: this, streams, solver, wallet, self, fair: (send) => new FairPlay(id, storage, this, send),
    });
  }

  /** Enters a room at once. @param {string} id */
  enter(id) {
    if (id === this.room.id) return;
    this.stop("player");
    this.#runs = [];
    this.moving = null;
    this.room.close();
    this.room = this.#open(id);
    this.tell("room", null);
    this.tell("account", null);
  }

  /** Moves to a board's room, once our balls have landed. @param {TableChoice} choice */
  async move(choice) {
    this.stop("player");
    if (this.room.own.unseen > 0 && this.room.practice !== "offline") {
      this.moving = choice;
      this.say(t("play.moving"), { urgent: true });
      return;
    }
    this.moving = null;
    try {
      const room = await findTable(choice, this.#mainBoard, this.visited);
      if (room === this.room.id) return;
      putIntoAddress(room);
      this.enter(room);
    } catch {
      this.say(t("play.table-fails"), { urgent: true });
      this.tell("choice", null);
    }
  }

  /** @returns {TableChoice | null} this room's board; null before it is known, and if the form does not offer it */
  get played() {
    return this.room.hello && choiceOf(this.room.hello);
  }

  /** Moves to the same board in another world. @param {World} world */
  travel({ gravity, material }) {
    if (this.played) void this.move({ ...this.played, gravity, material });
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
    return this.choice.seed === null ? this.room.practice : "seed";
  }

  /** The account as panels show it: stakes not yet answered are already deducted. */
  get account() {
    return viewOf(this.wallet.account, this.room.own.held);
  }

  /** The running auto-drop. @returns {Run | null} */
  get auto() {
    return this.#runs.find(({ limits, stopped }) => limits && !stopped) ?? null;
  }

  /** Whether our balls are in flight, or still to be dropped. */
  get busy() {
    return this.#runs.some(({ over }) => !over);
  }

  /** @returns {number} our balls in flight */
  get falling() {
    return this.#runs.reduce((sum, { falling }) => sum + falling, 0);
  }

  /** @param {number | null} [aim] m, instead of the aim set on the desk */
  drop(aim = this.choice.aim) {
    this.#add(this.#runs.find(({ limits }) => !limits) ?? new Run(), this.choice.balls, aim);
  }

  /** Infinite values mean no limit. @param {{rate: number, count: number, win: number, loss: number}} asked */
  startAuto({ rate, count, win, loss }) {
    this.#add(new Run({ win, loss }), count, this.choice.aim, rate);
  }

  /** @param {Run} run @param {number} balls @param {number | null} aim @param {number} [rate] a second */
  #add(run, balls, aim, rate) {
    if (!this.#runs.includes(run)) this.#runs.push(run);
    run.add(balls, this.#dropper(run, aim), performance.now(), rate);
    this.#pump();
  }

  /** Stops dropping; balls in flight still count. @param {"player" | "refused"} why */
  stop(why) {
    for (const run of this.#runs) run.stop(why);
    this.#finish();
  }

  /** @param {Run} run @param {number | null} aim @returns {() => string | null} drops a ball, returns its ref */
  #dropper(run, aim) {
    let { seed } = this.choice;
    return () => {
      const { stake } = this.choice;
      if (!this.practice && stake > this.account.balance) {
        this.say(t("play.too-few"), { urgent: true });
        run.stop("credits");
        return null;
      }
      const ref = this.room.drop({ seed, aim, stake });
      if (seed !== null) seed = seedAfter(seed);
      if (ref === null) this.say(t("play.no-line"), { urgent: true });
      else this.tell("account", null);
      return ref;
    };
  }

  #pump() {
    clearTimeout(this.#timer);
    const now = performance.now();
    const wait = Math.min(...this.#runs.map((run) => run.give(now, () => this.room.hasRoom)));
    if (Number.isFinite(wait)) this.#timer = window.setTimeout(() => this.#pump(), Math.max(4, wait));
    this.#finish();
  }

  /** Books a drop whose landing was shown, in every panel at once. @param {Played} played */
  #seen(played) {
    const { fair, stake, score, practice } = played;
    const payout = payoutOf(Math.round(stake * MINOR_UNITS), score);
    if (fair) this.wallet.apply({ type: "settled", ...fair, payout, played });
    else if (practice) this.wallet.apply({ type: "practised", played });
    for (const run of this.#runs) if (run.land(played)) break;
    this.tell("account", null);
    this.#finish();
  }

  /** Reports the runs whose balls have all landed, and moves to the next table if the player has chosen one. */
  #finish() {
    const over = this.#runs.filter((run) => run.over);
    this.#runs = this.#runs.filter((run) => !run.over);
    for (const run of over) {
      const words = run.words();
      if (words) this.say(words.text, { score: words.score, urgent: run.limits !== null });
    }
    this.tell("run", null);
    const { moving } = this;
    if (!moving || this.room.own.unseen > 0) return;
    this.moving = null;
    void this.move(moving);
  }

  refill() {
    this.wallet.apply(refillOf(this.wallet.account));
    this.tell("account", null);
    this.say(t("play.refilled", { balance: plain(this.account.balance) }), { urgent: true });
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
  return t("play.found", {
    n: played.length, board: name, staked: plain(staked), paid: amount(paid), profit: signed(paid - staked),
  });
}
