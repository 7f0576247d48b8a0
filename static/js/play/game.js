// The state of the live page: the room, the player's account, what is set on the desk, what was dropped together.
// Panels read it, subscribe to its news, and ask it to act; none of them knows another.

import { payoutOf } from "../fairness/payout.js";
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
 * @typedef {object} Choice what is set on the desk
 * @property {string | null} seed of practice; null where the table draws one
 * @property {number | null} aim m; null for the board's own start
 * @property {number} stake credits
 * @property {number} balls of one push
 * @property {Pace} pace
 */

const CHOICE_KEY = "plinko.choice.1";

/** The store that all panels share. */
export class Game extends Store {
  /** @type {Choice} */
  choice;
  /** @type {Odds | null} of the table that is played at */
  odds = null;
  /** Balls that are told together, until all are down. @type {Run[]} */
  #runs = [];
  #timer = 0;
  /** The board of the main room, as far as it is known. @type {string | null} */
  #mainBoard = null;
  /** A table to go to once our balls are down. @type {TableChoice | null} */
  moving = null;

  /** @param {{storage: Storage, solver: Solver | null, streams: string[], room: string}} means */
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
    let there = true; // the line
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

  /** @param {string} id of a room: goes there at once */
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

  /** Goes to the table of a board, once balls of ours are down. @param {TableChoice} choice */
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

  /** @returns {TableChoice | null} what is played; null before it is known, and of a board that nobody can choose */
  get played() {
    return this.room.hello && choiceOf(this.room.hello);
  }

  /** Goes to the same board in another world. @param {World} world */
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

  /** @returns {Reason | null} why drops count for nothing now; null when they are staked */
  get practice() {
    return this.choice.seed === null ? this.room.practice : "seed";
  }

  /** The account as all panels show it. */
  get account() {
    return viewOf(this.wallet.account, this.room.own.held);
  }

  /** The auto-drop that is under way. @returns {Run | null} */
  get auto() {
    return this.#runs.find(({ limits, stopped }) => limits && !stopped) ?? null;
  }

  /** Balls of ours that are in flight, or still to be dropped one by one. */
  get busy() {
    return this.#runs.some(({ over }) => !over);
  }

  /** @returns {number} balls of ours that are in flight */
  get falling() {
    return this.#runs.reduce((sum, { falling }) => sum + falling, 0);
  }

  /** @param {number | null} [aim] m, where it is not the one that is chosen */
  drop(aim = this.choice.aim) {
    this.#add(this.#runs.find(({ limits }) => !limits) ?? new Run(), this.choice.balls, aim);
  }

  /** @param {{rate: number, count: number, win: number, loss: number}} asked infinite: without that end */
  startAuto({ rate, count, win, loss }) {
    this.#add(new Run({ win, loss }), count, this.choice.aim, rate);
  }

  /** @param {Run} run @param {number} balls @param {number | null} aim @param {number} [rate] a second */
  #add(run, balls, aim, rate) {
    if (!this.#runs.includes(run)) this.#runs.push(run);
    run.add(balls, this.#dropper(run, aim), performance.now(), rate);
    this.#pump();
  }

  /** No more balls are dropped; those in flight count. @param {"player" | "refused"} why */
  stop(why) {
    for (const run of this.#runs) run.stop(why);
    this.#finish();
  }

  /** @param {Run} run @param {number | null} aim @returns {() => string | null} drops one ball after the other */
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

  /** @param {Played} played it is final, in every panel at once */
  #seen(played) {
    const { fair, stake, score, practice } = played;
    const payout = payoutOf(Math.round(stake * MINOR_UNITS), score);
    if (fair) this.wallet.apply({ type: "settled", ...fair, payout, played });
    else if (practice) this.wallet.apply({ type: "practised", played });
    for (const run of this.#runs) if (run.land(played)) break;
    this.tell("account", null);
    this.#finish();
  }

  /** What is down is told. */
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

  /** Statistics and history begin again; the balance stays. */
  reset() {
    this.wallet.apply({ type: "reset" });
    this.tell("account", null);
  }
}

/** @param {Played[]} played of one session, found after the page had left @returns {string} */
function foundWords(played) {
  const [{ name }] = played;
  const staked = played.reduce((sum, { stake }) => sum + stake, 0);
  const paid = played.reduce((sum, one) => sum + one.paid, 0);
  return t("play.found", {
    n: played.length, board: name, staked: plain(staked), paid: amount(paid), profit: signed(paid - staked),
  });
}
