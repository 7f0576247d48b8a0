// A live table: joins connection, clock and balls, and says what to draw and what happened.

import { Company } from "../model/table/company.js";
import { Table } from "../model/table/table.js";
import { socketUrl } from "../net/api.js";
import { Connection, ROOM_MOVED } from "../net/connection.js";
import { decodeEvents, decodeSnapshot, ProtocolError } from "../net/protocol.js";
import { decodeSegments } from "../net/segments.js";
import { SEEDS } from "../net/streams.js";
import { TickClock } from "../net/tick-clock.js";
import { t } from "../texts/text.js";
import { FairPlay } from "./fairness/fair-play.js";
import { fairPlaceOf, MINOR_UNITS, OwnDrops } from "./own-drops.js";
import { isPractice, Practice } from "./practice.js";
import { solveFor } from "./solving.js";

/** @import { Entry } from "../instruments/pile/columns.js" */
/** @import { Point } from "../model/board.js" */
/** @import { Accepted, BriefAccepted, BriefLanded, ClockMessage, Hello, Landed, Refusal, Missed, SessionEnded, Snapshot, TableMessage } from "../model/messages.js" */
/** @import { Played } from "../model/player/session.js" */
/** @import { Ball } from "../model/table/table.js" */
/** @import { SegmentScale } from "../net/segments.js" */
/** @import { Solver } from "../solver/solver.js" */
/** @import { Wallet } from "./account/wallet.js" */
/** @import { Self } from "./account/self.js" */
/** @import { Heard } from "./fairness/fair-play.js" */

/** @typedef {"connecting" | "live" | "asleep" | "reconnecting" | "closed"} LiveState */

/**
 * @typedef {object} LiveListener
 * @property {(hello: Hello, table: Table) => void} onTable a table is there, or there again
 * @property {(state: LiveState, detail?: string) => void} onState
 * @property {(played: Played) => void} onSeen a drop of ours is seen to land
 * @property {(played: Played) => void} onPlayed the table has told its landing, too
 * @property {(bin: number, entry: Entry) => void} onHit a ball, whosever, lies in a bin
 * @property {(message: string, code?: string) => void} onError
 * @property {() => void} onChange there is something new to draw
 * @property {(halted: boolean) => void} [onHalted] whoever runs the server lets no drops in, or does again
 * @property {() => void} [onCompany] somebody came, went, changed or landed
 * @property {() => void} [onSnapshot] the balls have new places
 * @property {() => void} [onSession] the session is another, or has gone on
 * @property {(ended: SessionEnded, heard: Heard) => void} [onEnded] a session is over
 * @property {(session: string) => void} [onBehind] drops of it have ended, or were taken, unheard of
 * @property {(ms: number) => void} [onPong] how long a message took there and back
 */

/**
 * What holds from one hello to the next.
 * @typedef {{hello: Hello, table: Table, clock: TickClock, scale: SegmentScale}} Visit
 */

const SEGMENTS = "segments"; // a segment of a path a bounce, from which the page draws the rest
const COUNTED = new Set(["accepted", "contact", "landed"]); // events that a room numbers

/** One room, through reconnections. */
export class LiveTable {
  /** The room's newest tick. @type {number | null} */
  tick = null;
  /** @type {Visit | null} */
  #visit = null;
  /** @type {LiveState} */
  #state = "connecting";
  /** Room events heard of so far, and how the server knows us again. */
  #seq = 0;
  /** @type {{run: string, key: string} | null} */
  #last = null;
  /** @type {Snapshot | undefined} whose columns are used again */
  #snapshot;

  /**
   * @param {string} room
   * @param {LiveListener} listener
   * @param {{streams: string[], solver: Solver | null, wallet: Wallet, self: Self}} means streams: those that
   *   will do, the best first; a page without a solver can do nothing with `seeds`
   */
  constructor(room, listener, { streams, solver, wallet, self }) {
    this.room = room;
    this.listener = listener;
    this.solver = solver;
    this.wallet = wallet;
    this.self = self;
    this.streams = streams;
    this.own = new OwnDrops(listener);
    this.practice = new Practice();
    this.company = new Company(() => listener.onCompany?.());
    this.fair = new FairPlay(room, window.localStorage, {
      send: (message) => this.connection.send(message),
      onChange: () => listener.onSession?.(),
      onEnded: (ended, heard) => listener.onEnded?.(ended, heard),
      onRefused: (ref) => this.own.refused(ref),
      ...wallet.hearing(room, (session) => listener.onBehind?.(session)),
      onFault: (message) => listener.onError(message),
    });
    this.connection = this.#connect();
  }

  #connect() {
    return new Connection(socketUrl(this.room, this.streams[0]), {
      onText: (text) => this.#read(() => {
        for (const event of /** @type {TableMessage[]} */ (decodeEvents(text))) this.#take(event);
      }),
      onBytes: (bytes) => this.#read(() => this.#takeBytes(bytes)),
      onLost: (waitMs) => this.#setState("reconnecting", String(Math.max(1, Math.round(waitMs / 1000)))),
      onRefused: (reason) => this.#setState("closed", reason),
      // A ball that flies for long sends no segments meanwhile.
      onQuiet: () => this.ping(),
    });
  }

  /**
   * The next best stream, where the one that was asked for will not do.
   * @returns {boolean} false when there is none
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

  /** Whether drops that nobody chose are staked here. */
  get takesStakes() {
    return this.hello?.mode === "independent";
  }

  /** @returns {Hello | null} */
  get hello() {
    return this.#visit?.hello ?? null;
  }

  /**
   * Staked in the session; with a seed of one's own it is practice, and nothing is staked.
   * @param {{seed: string | null, aim: number | null, stake?: number}} ask
   * @returns {boolean} false when there is no line and no practice: nothing was dropped
   */
  drop({ seed, aim, stake = 1 }) {
    if (!this.#visit) return false;
    const ref = this.own.nextRef();
    const ours = { who: this.wallet.mark.value, ...(aim !== null && { aim }) };
    const minor = Math.round(stake * MINOR_UNITS);
    const staked = seed === null && this.fair.drop(ref, { stake: minor, ...ours });
    // Where others may knock the ball nothing is staked, either.
    const plain = { type: "drop", ref, ...(seed !== null && { seed }), ...ours };
    if (!staked && !this.connection.send(plain)) return this.#practise({ seed, aim });
    this.own.add(ref, staked ? stake : 0, seed !== null);
    this.connection.expectNews(true);
    return true;
  }

  /** @param {{seed: string | null, aim: number | null}} ask */
  #practise(ask) {
    if (!this.#visit?.table.solve) return false;
    const { table, clock, hello } = this.#visit;
    const now = performance.now();
    if (!table.flying) clock.observe(this.tick ?? hello.tick, now);
    this.practice.drop(table, ask, clock.renderTick(now));
    this.listener.onError(t("play.no-line-practice"));
    this.listener.onChange();
    return true;
  }

  /** @param {number} nowMs @returns {number} table time to draw, s */
  time(nowMs) {
    const clock = this.#visit?.clock;
    return clock ? clock.renderTick(nowMs) / clock.rate : 0;
  }

  /**
   * Settles what is due: scores, histogram, messages.
   * @param {number} due table time up to which landings count, s
   * @param {number | null} nowMs local time; null lights nothing up
   */
  settle(due, nowMs) {
    const { table } = this;
    if (!table) return;
    const { seen, settled } = table.settle(due, nowMs === null ? null : nowMs / 1000);
    for (const ball of seen) this.#seen(ball);
    for (const ball of settled) this.#settled(ball);
    this.#rest(table);
  }

  /** @returns {Point[][]} the way our last ball took, as lines */
  ownPaths() {
    return this.table?.lastTrace ? [this.table.lastTrace.points()] : [];
  }

  /** Asks how long a message takes there and back; the answer is told by `onPong`. */
  ping() {
    return this.connection.send({ type: "ping", t: performance.now() });
  }

  close() {
    this.connection.close();
  }

  /**
   * A server that speaks another protocol will go on doing so: no use in coming back.
   * @param {() => void} message
   */
  #read(message) {
    try {
      message();
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.connection.close();
      this.#setState("closed", t("play.foreign", { why: error.message }));
    }
  }

  /** @param {TableMessage} event */
  #take(event) {
    if (COUNTED.has(event.type)) this.#seq += 1;
    // A newer server may send more kinds; what this page does not know it can do without.
    if (event.type === "hello") this.#greeted(event);
    else if (event.type === "missed") this.#missed(event.events ?? []);
    else if (event.type === "accepted") this.#accepted(event);
    else if (event.type === "contact") this.table?.applyContact(event);
    else if (event.type === "landed") this.#landed(event);
    else if (event.type === "clock") this.#hearClock(event);
    else if (event.type === "error") this.#refused(event);
    else if (event.type === "session") this.fair.told(event);
    else if (event.type === "ended") this.fair.ended(event);
    else if (event.type === "halted") this.listener.onHalted?.(event.halted);
    else if (event.type === "presence") this.company.hear(event, this.table?.balls.values());
    else if (event.type === "pong") this.listener.onPong?.(performance.now() - event.t);
    this.listener.onChange();
  }

  /** @param {Hello} hello */
  #greeted(hello) {
    this.connection.settled();
    const scale = {
      extent: hello.extent,
      velocityScale: hello.velocity_scale,
      spinScale: hello.spin_scale,
      rate: hello.tick_rate,
    };
    const solve = solveFor(this.solver, hello);
    if (hello.stream === SEEDS && !solve && this.#retreat()) return;
    const table = new Table(hello, solve);
    this.#visit = { hello, table, clock: new TickClock({ rate: hello.tick_rate }), scale };
    if (solve && table.awake) this.#visit.clock.observe(hello.tick, performance.now());
    this.tick = hello.tick;
    const pending = this.own.enter(hello, table);
    for (const session of this.own.adopt(this.wallet.openIn(this.room))) this.listener.onBehind?.(session);
    this.fair.greeted(hello);
    this.company.begin();
    this.appear();
    this.listener.onTable(hello, table);
    this.#resume(hello, pending);
    this.#setState(table.flying ? "live" : "asleep");
    this.connection.expectNews(table.flying);
  }

  /** Says who we are, to those at the table who said so, too. */
  appear() {
    this.connection.send(this.self.message);
  }

  /** @param {ClockMessage} event */
  #hearClock({ tick, seq }) {
    this.#seq = seq; // contacts are among them, which this stream does not tell
    this.tick = tick;
    this.#visit?.clock.observe(tick, performance.now());
  }

  /**
   * After a lost line: asks what we have missed of what became of our drops.
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
    this.fair.accepted(event);
    const ball = table.accept(event, this.own.has(event.ref));
    this.company.dye(ball);
    this.own.accepted(event.ref, ball, fairPlaceOf(event));
    this.#setState("live");
    this.connection.expectNews(true);
  }

  /** @param {Landed | BriefLanded} event */
  #landed(event) {
    if (this.table && !this.table.applyLanded(event)) {
      this.#seq -= 1; // what became of it is asked for again
      this.listener.onError(t("play.other-path"));
      this.#retreat();
      return;
    }
    // Nobody looks at a hidden tab, and it gets no pictures: what landed there counts at once.
    if (document.visibilityState === "hidden") {
      const now = performance.now();
      this.settle(Number.POSITIVE_INFINITY, null);
      this.table?.forget(this.time(now), now / 1000);
    }
  }

  /** @param {Ball} ball */
  #seen(ball) {
    const { outcome } = ball;
    if (!outcome || !this.hello) return;
    if (isPractice(ball)) this.listener.onSeen(this.practice.played(this.hello, this.own.address, ball));
    else {
      if (outcome.bin !== null) this.listener.onHit(outcome.bin, { x: outcome.x_end, speed: ball.sink?.vy ?? 0 });
      this.company.landed(ball, outcome);
      this.own.seen(ball, outcome);
    }
  }

  /** @param {Ball} ball */
  #settled(ball) {
    if (!ball.landed || !this.hello) return;
    if (isPractice(ball)) this.listener.onPlayed(this.practice.played(this.hello, this.own.address, ball));
    else this.own.settled(ball, ball.landed);
  }

  /** @param {Refusal} event */
  #refused(event) {
    // Before it has greeted, a server refuses what it is asked for: one that knows no such stream.
    if (!this.#visit && event.code === "invalid-value" && this.#retreat()) return;
    this.own.refused(event.ref);
    if (this.fair.refused(event)) return;
    if (event.code !== ROOM_MOVED) this.listener.onError(event.detail, event.code);
    if (this.table) this.#rest(this.table);
  }

  /** @param {ArrayBuffer} bytes */
  #takeBytes(bytes) {
    if (!this.#visit) return;
    const { hello, clock } = this.#visit;
    this.tick = hello.stream === SEGMENTS
      ? this.#takeSegments(this.#visit, bytes)
      : this.#takeSnapshot(this.#visit, bytes);
    clock.observe(this.tick, performance.now());
    this.listener.onChange();
  }

  /** @param {Visit} visit @param {ArrayBuffer} bytes @returns {number} its tick */
  #takeSegments({ table, scale }, bytes) {
    const message = decodeSegments(bytes, scale);
    this.#seq = message.seq; // contacts are among them, which this stream does not tell
    table.applySegments(message);
    return message.tick;
  }

  /** @param {Visit} visit @param {ArrayBuffer} bytes @returns {number} its tick */
  #takeSnapshot({ table, scale }, bytes) {
    this.#snapshot = decodeSnapshot(bytes, scale, this.#snapshot);
    table.applySnapshot(this.#snapshot);
    this.listener.onSnapshot?.();
    return this.#snapshot.tick;
  }

  /**
   * Nothing in flight and nothing asked for: the line may be silent as long as it likes.
   * @param {Table} table
   */
  #rest(table) {
    if (table.awake || this.own.unanswered > 0 || this.#state === "reconnecting") return;
    this.connection.expectNews(false);
    if (table.shown) this.#setState("asleep");
  }

  /** @param {LiveState} state @param {string} [detail] */
  #setState(state, detail) {
    if (state === this.#state && detail === undefined) return;
    this.#state = state;
    this.listener.onState(state, detail);
  }
}
