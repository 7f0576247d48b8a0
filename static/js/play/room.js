// One room, over all its connections: the socket, the clock, the balls, our drops, the fair session, the players.

import { Visitors } from "../model/table/visitors.js";
import { MAIN_BOARD, MAIN_ROOM, readBoardName } from "../model/presets.js";
import { MINOR_UNITS } from "../model/player/account.js";
import { randomSeed } from "../model/seed.js";
import { Table } from "../model/table/table.js";
import { getJson, SEEDS, socketUrl } from "../net/api.js";
import { Connection, ROOM_MOVED } from "../net/connection.js";
import { decodeEvents, decodeSnapshot } from "../net/protocol.js";
import { TickClock } from "../net/tick-clock.js";
import { PHYSICS_VERSION } from "../solver/digest.js";
import { BoardError } from "../solver/errors.js";
import { t } from "../texts/text.js";
import { pause } from "../util/frame-loop.js";
import { fairPlaceOf, OwnDrops } from "./own-drops.js";

/** @import { Accepted, BriefAccepted, BriefLanded, ClockMessage, Hello, Landed, Refusal, Missed, TableMessage } from "../model/messages.js" */
/** @import { Ball, Solve } from "../model/table/table.js" */
/** @import { BoardReply } from "../net/replies.js" */
/** @import { SnapshotScale } from "../net/protocol.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Key } from "../texts/text.js" */
/** @import { Self } from "./account/self.js" */
/** @import { Wallet } from "./account/wallet.js" */
/** @import { FairPlay } from "./fairness/fair-play.js" */
/** @import { Store } from "./store.js" */

/** @typedef {"connecting" | "live" | "asleep" | "reconnecting" | "full" | "closed"} LineState */
/** @typedef {"seed" | "aim" | "colliding" | "unsolved" | "offline" | "unsealed"} Reason why a drop is practice */

/**
 * The state that each hello replaces.
 * @typedef {{hello: Hello, table: Table, clock: TickClock, scale: SnapshotScale}} Visit
 */

/** States without a connection to the room. @type {LineState[]} */
export const LOST = ["reconnecting", "full", "closed"];
const ROOM_FULL = "room-full"; // error code: the server closes the connection, and a later one may find a place
const UNDECIDED = "undecided"; // error code: the server does not know yet whether it has taken the drop
const ROOM_RESET = "room-reset"; // error code: the ledger has the drop, but its ball has not entered the room
const RATE_MARGIN = 1.1; // the server's clock and the network are not exact
const COUNTED = new Set(["accepted", "contact", "landed"]); // events with a sequence number
/** The texts shown for refusals, by error code. @type {Record<string, Key>} */
const REFUSALS = {
  "rate-limited": "refused.rate", "too-many-messages": "refused.rate", "too-many-balls": "refused.full",
  "room-halted": "play.halted",
  banned: "play.banned",
};

/** A room as panels see it; its changes are announced through `news`. */
export class Room {
  /** The room's newest tick. @type {number | null} */
  tick = null;
  /** @type {LineState} */
  state = "connecting";
  /** Seconds until the next attempt to reconnect. */
  wait = 0;
  /** @type {Visit | null} */
  #visit = null;
  /** The sequence number of the last event received. */
  #seq = 0;
  /** The room run and key by which a reconnect resumes this connection. @type {{run: string, key: string} | null} */
  #last = null;
  #drops = 0;
  #practised = 0;
  #closed = false;
  #offline = false; // whether this page made the table itself, without a server
  #full = false; // whether the last connection was refused because the room has no place left
  #sentMs = Number.NEGATIVE_INFINITY; // when the last drop was sent

  /**
   * @param {string} id
   * @param {{news: Store, streams: string[], solver: Solver | null, wallet: Wallet, self: Self | null,
   *   fair: (send: (message: object) => boolean) => FairPlay}} options streams: acceptable streams, the best first;
   *   self: null for an audience, which sees visitors and is none
   */
  constructor(id, { news, streams, solver, wallet, self, fair }) {
    this.id = id;
    this.news = news;
    this.solver = solver;
    this.wallet = wallet;
    this.self = self;
    this.streams = streams;
    this.own = new OwnDrops(news);
    this.visitors = new Visitors(() => news.tell("visitors", null));
    this.fair = fair((message) => this.connection.greeted && this.connection.send(message));
    this.connection = this.#connect();
  }

  #connect() {
    return new Connection(socketUrl(this.id, this.streams[0]), {
      onText: (text) => {
        for (const event of /** @type {TableMessage[]} */ (decodeEvents(text))) this.#take(event);
      },
      onBytes: (bytes) => this.#takeBytes(bytes),
      onForeign: () => {
        this.#setState("closed");
        this.news.say(t("play.foreign"), { urgent: true });
      },
      onLost: (waitMs) => this.#lost(waitMs),
      onRefused: () => this.#setState("closed"),
      // A ping shows whether the connection still works.
      onQuiet: () => this.connection.send({ type: "ping", t: performance.now() }),
    });
  }

  /**
   * Reconnects with the next best stream, where the current one does not work.
   * @returns {boolean} false if there is none
   */
  #retreat() {
    if (this.streams.length < 2) return false;
    this.connection.close();
    this.streams = this.streams.slice(1);
    this.connection = this.#connect();
    return true;
  }

  /** @returns {Table | null} null before the first hello */
  get table() {
    return this.#visit?.table ?? null;
  }

  /** @returns {Hello | null} */
  get hello() {
    return this.#visit?.hello ?? null;
  }

  /** @returns {Reason | null} why every drop here is practice; null if drops can be staked */
  get practice() {
    if (!this.#visit) return null;
    if (this.hello?.mode === "interacting") return "colliding";
    if (this.#offline || LOST.includes(this.state)) return "offline";
    if (this.hello?.stakes === false && !this.hello.draw) return "unsolved";
    return this.fair.failed ? "unsealed" : null;
  }

  /** Whether the room takes one more ball now: it is entered, has space for it, and got its last one long enough ago. */
  get hasRoom() {
    if (this.state === "connecting") return false;
    // A connection that the server has sent on comes back at once: what is to be dropped waits.
    if (this.#visit && !this.connection.greeted && !this.practice) return false;
    const { balls: most, drops_per_second: rate } = this.hello?.limits ?? {};
    if (rate && performance.now() - this.#sentMs < RATE_MARGIN * 1000 / rate) return false;
    return (this.table?.balls.size ?? 0) + this.own.unanswered < (most ?? Number.POSITIVE_INFINITY);
  }

  /**
   * Sends a drop. It is practice if the player chose its seed or its start, whose return is another than the board's,
   * or if only practice is possible; else it is staked.
   * @param {{seed: string | null, aim: number | null, stake: number}} ask
   * @returns {string | null} its ref; null if it could not be sent
   */
  drop({ seed, aim, stake }) {
    if (!this.#visit) return null;
    const ref = `d${this.#drops}`;
    this.#drops += 1;
    const ours = { who: this.wallet.mark, ...(aim !== null && { aim }) };
    const credits = this.hello?.stakes === false ? 0 : stake; // a draw's drops are fair, but take no stakes
    const practice = seed !== null || aim !== null || this.practice !== null;
    const plain = { type: "drop", ref, ...(seed !== null && { seed }), ...ours };
    if (practice && (this.#offline || !this.connection.send(plain))) return this.#practise(ref, { seed, aim });
    if (!practice && !this.fair.drop(ref, { stake: Math.round(credits * MINOR_UNITS), ...ours })) return null;
    this.#sentMs = performance.now();
    this.own.add(ref, practice ? 0 : credits, practice);
    this.connection.expectNews(true);
    this.news.tell("room", null);
    return ref;
  }

  /**
   * Drops a ball that exists only in this page.
   * @param {string} ref @param {{seed: string | null, aim: number | null}} ask
   */
  #practise(ref, { seed, aim }) {
    const { table, clock, hello } = /** @type {Visit} */ (this.#visit);
    if (!table.solve) return null;
    const now = performance.now();
    if (!table.flying) clock.observe(this.tick ?? hello.tick, now);
    this.#practised += 1;
    const drawn = seed ?? randomSeed();
    const start = { ball: -this.#practised, seed: drawn, tick: clock.renderTick(now), ...(aim !== null && { aim }) };
    const ball = table.accept({ type: "accepted", ref, ...start }, true);
    this.own.add(ref, 0, true);
    this.own.accepted(ref, ball);
    table.applyLanded({ type: "landed", ball: ball.id, digest: ball.solved?.digest ?? "" });
    this.news.tell("picture", null);
    return ref;
  }

  /** @param {number} nowMs @returns {number} table time to draw, s */
  time(nowMs) {
    const clock = this.#visit?.clock;
    return clock ? clock.renderTick(nowMs) / clock.rate : 0;
  }

  /**
   * Announces landings: those that the picture now shows, and those that the server has sent.
   * @param {number} due table time up to which landings have been shown, s
   * @param {number | null} nowMs local time; null for no flash
   */
  settle(due, nowMs) {
    const { table } = this;
    if (!table) return;
    const { seen, settled } = table.settle(due, nowMs === null ? null : nowMs / 1000);
    for (const ball of seen) this.#seen(ball);
    for (const ball of settled) if (ball.landed) this.own.settled(ball, ball.landed);
    this.#rest(table);
  }

  /** Sends our name and colour to the room. All tabs of a player are one visitor; an audience is none. */
  appear() {
    const { self, wallet } = this;
    this.connection.send(self ? { ...self.message, who: wallet.mark } : { type: "appear", audience: true });
  }

  /** Leaves the room: nothing more is announced. */
  close() {
    this.#closed = true;
    this.connection.close();
  }

  /** @param {TableMessage} event */
  #take(event) {
    if (COUNTED.has(event.type)) this.#seq += 1;
    // A newer server may send further types: unknown ones are ignored.
    if (event.type === "hello") this.#greeted(event);
    else if (event.type === "missed") this.#missed(event.events ?? []);
    else if (event.type === "accepted") this.#accepted(event);
    else if (event.type === "contact") this.table?.applyContact(event);
    else if (event.type === "landed") this.#landed(event);
    else if (event.type === "clock") this.#hearClock(event);
    else if (event.type === "error") this.#refused(event);
    else if (event.type === "session") this.fair.told(event);
    else if (event.type === "ended") this.fair.ended(event);
    else if (event.type === "halted") this.news.tell("halted", event.halted);
    else if (event.type === "notice") this.news.tell("notice", event);
    else if (event.type === "queue") this.news.tell("queue", event);
    else if (event.type === "show") this.news.tell("show", null);
    else if (event.type === "presence") this.visitors.hear(event, this.table?.balls.values());
    this.news.tell("picture", null);
  }

  /** @param {Hello} hello */
  #greeted(hello) {
    this.connection.settled();
    const solve = this.#solveFor(hello);
    if (hello.stream === SEEDS && !solve && this.#retreat()) return;
    this.#offline = false;
    this.#full = false;
    // After a reset the server goes on with the same connection, and so with the same key.
    const held = this.#last !== null && this.#last.key === hello.key;
    this.settle(Number.POSITIVE_INFINITY, null); // the table before, whose landings have all arrived
    const { table, clock } = this.#enter(hello, solve);
    if (table.solve && table.awake) clock.observe(hello.tick, performance.now());
    const pending = this.own.enter(hello, table, held);
    const open = this.wallet.open.filter(({ room }) => room === this.id);
    for (const session of this.own.adopt(open)) this.news.tell("behind", session);
    this.fair.greeted(hello, held);
    this.visitors.begin();
    for (const ball of table.balls.values()) this.visitors.dye(ball);
    this.appear();
    this.news.tell("table", { hello, table });
    this.#resume(hello, pending);
    this.#setState(table.flying ? "live" : "asleep");
    this.connection.expectNews(table.flying);
  }

  /** @param {Hello} hello @param {Solve | null} solve @returns {Visit} */
  #enter(hello, solve) {
    const table = new Table(hello, solve);
    const scale = { extent: hello.extent, velocityScale: hello.velocity_scale };
    this.#visit = { hello, table, clock: new TickClock({ rate: hello.tick_rate }), scale };
    this.tick = hello.tick;
    return this.#visit;
  }

  /**
   * A preset is known to be right, so that it can be read a moment later.
   * @param {Hello} hello @returns {Solve | null} null for another stream, or if this page cannot compute the board
   */
  #solveFor({ stream, board, board_name: name, physics_version: version }) {
    const { solver } = this;
    if (stream !== SEEDS || !solver || version !== PHYSICS_VERSION) return null;
    try {
      let whole = readBoardName(name) ? null : solver.read(board);
      const read = () => (whole ??= solver.read(board));
      void pause().then(read);
      return (start) => solver.drop(read(), start);
    } catch (error) {
      if (!(error instanceof BoardError)) throw error;
      return null;
    }
  }

  /** @param {number} waitMs */
  #lost(waitMs) {
    this.wait = Math.max(1, Math.round(waitMs / 1000));
    this.#setState(this.#full ? "full" : "reconnecting");
    if (!this.#full && !this.#visit && this.solver) void this.#openOffline();
  }

  /** Without a server, offers practice on the room's board, if the browser has cached it. */
  async #openOffline() {
    const name = this.id === MAIN_ROOM || !readBoardName(this.id) ? MAIN_BOARD : this.id;
    const reply = await getJson(`boards/${name}`).catch(() => null);
    if (!reply || this.#visit || this.#closed) return;
    const { board, digest } = /** @type {BoardReply} */ (reply);
    const hello = /** @type {Hello} */ ({
      type: "hello", room: this.id, board, board_name: name, board_digest: digest, slots: board.drop.slots ?? [],
      mode: "independent", tick_rate: 60, tick: 0, seq: 0, stream: SEEDS, physics_version: PHYSICS_VERSION,
      limits: { balls: 200 }, balls: /** @type {Hello["balls"]} */ ([]),
      stats: { histogram: board.bins.multipliers.map(() => 0) },
    });
    this.#offline = true;
    const { table } = this.#enter(hello, this.#solveFor(hello));
    this.own.enter(hello, table);
    this.news.tell("table", { hello, table });
    this.news.tell("room", null);
  }

  /** @param {ClockMessage} event */
  #hearClock({ tick, seq }) {
    this.#seq = seq; // it also counts contacts, which this stream does not send
    this.tick = tick;
    this.#visit?.clock.observe(tick, performance.now());
  }

  /**
   * After a reconnect: requests the events that we have missed, if drops of ours are pending.
   * @param {Hello} hello
   * @param {boolean} pending
   */
  #resume({ run, key, seq }, pending) {
    const last = this.#last;
    const since = this.#seq;
    this.#last = { run, key };
    this.#seq = seq;
    if (!pending) return;
    if (last?.run) this.connection.send({ type: "resume", since, ...last });
    else this.own.reclaim([]);
  }

  /** @param {NonNullable<Missed["events"]>} events */
  #missed(events) {
    for (const event of events) {
      if (event.type === "accepted" && this.own.awaits(event.ref)) this.fair.accepted(event);
    }
    this.own.reclaim(events);
  }

  /** @param {Accepted | BriefAccepted} event */
  #accepted(event) {
    if (!this.#visit) return;
    this.tick = event.tick;
    const { table, clock } = this.#visit;
    if (!table.awake) clock.restart();
    clock.observe(event.tick, performance.now());
    const ball = table.accept(event, this.own.has(event.ref));
    this.visitors.dye(ball);
    this.own.accepted(event.ref, ball, fairPlaceOf(event));
    this.fair.accepted(event);
    this.#setState("live");
    this.connection.expectNews(true);
  }

  /** @param {Landed | BriefLanded} event */
  #landed(event) {
    if (this.table && !this.table.applyLanded(event)) {
      this.#seq -= 1; // so that the reconnect requests this landing again
      this.news.say(t("play.other-path"), { urgent: true });
      this.#retreat();
      return;
    }
    // A hidden tab draws no frames, so no landing would ever be shown: landings count at once.
    if (document.visibilityState === "hidden") {
      const now = performance.now();
      this.settle(Number.POSITIVE_INFINITY, null);
      this.table?.forget(this.time(now), now / 1000);
    }
  }

  /** @param {Ball} ball */
  #seen(ball) {
    const { outcome } = ball;
    if (!outcome) return;
    // A ball with a number below 0 fell only in this page, and the room has not counted it.
    if (ball.id >= 0) {
      if (outcome.bin !== null) {
        const entry = { x: outcome.x_end, speed: ball.sink?.vy ?? 0 };
        this.news.tell("hit", { bin: outcome.bin, entry, owner: this.visitors.ownerOf(ball) });
      }
      this.news.tell("landed", this.visitors.landed(ball, outcome));
    }
    this.own.seen(ball, outcome);
  }

  /** @param {Refusal} event */
  #refused({ ref, code }) {
    // A refusal before the hello means that the server does not know the stream.
    if (!this.#visit && code === "invalid-value" && this.#retreat()) return;
    if (code === UNDECIDED) return; // the answer follows
    if (code === ROOM_FULL) {
      this.#full = true; // the server closes the connection
      return;
    }
    const session = this.fair.state?.session;
    const ours = this.own.has(ref);
    this.own.refused(ref);
    if (this.fair.refused({ ref, code })) return;
    if (code === ROOM_RESET && session) this.news.tell("behind", session);
    else if (code !== ROOM_MOVED && ours) {
      this.news.say(t(REFUSALS[code] ?? "refused.other"), { urgent: true });
    }
    if (this.table) this.#rest(this.table);
  }

  /** @param {ArrayBuffer} bytes */
  #takeBytes(bytes) {
    if (!this.#visit) return;
    const { hello, table, clock, scale } = this.#visit;
    const snapshot = decodeSnapshot(bytes, scale, this.tick ?? hello.tick);
    this.tick = snapshot.tick;
    table.applySnapshot(snapshot);
    clock.observe(this.tick, performance.now());
    this.news.tell("picture", null);
  }

  /**
   * With nothing in flight and nothing unanswered, the server may be silent for any time.
   * @param {Table} table
   */
  #rest(table) {
    if (table.awake || this.own.unanswered > 0 || LOST.includes(this.state)) return;
    this.connection.expectNews(false);
    if (table.shown) this.#setState("asleep");
  }

  /** @param {LineState} state */
  #setState(state) {
    if (state === this.state && state !== "reconnecting" && state !== "full") return;
    this.state = state;
    this.news.tell("room", null);
  }
}
