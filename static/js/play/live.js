// A live table: joins connection, clock and balls, and says what to draw and what happened.

import { boardAddress, getJson, socketUrl } from "../net/api.js";
import { TickClock } from "../net/tick-clock.js";
import { Connection } from "../net/connection.js";
import { dropPath } from "../net/drop-address.js";
import { decodeEvents, decodeSnapshot, ProtocolError } from "../net/protocol.js";
import { decodeSegments } from "../net/segments.js";
import { Table } from "../model/table/table.js";

/**
 * @typedef {object} LiveListener
 * @property {(hello: any, counts: number[]) => void} onTable a table is there, or there again
 * @property {(state: "connecting" | "live" | "asleep" | "reconnecting" | "closed", detail?: string)
 *   => void} onState
 * @property {(played: import("../model/session.js").Played) => void} onPlayed a drop of ours has settled
 * @property {(bin: number) => void} onHit a ball, whosever, lies in a bin
 * @property {(message: string, code?: string) => void} onError
 * @property {() => void} onChange there is something new to draw
 * @property {() => void} [onSnapshot] the balls have new places
 * @property {(ms: number) => void} [onPong] how long a message took there and back
 */

const MINOR_UNITS = 100; // the server counts stakes in hundredths
const SEGMENTS = "segments"; // a piece of a path a bounce, from which the page draws the rest
const COUNTED = new Set(["accepted", "contact", "landed"]); // events that a room numbers

/** What a drop needs to know of its ball, from an acceptance that came late. */
function ballOf(event) {
  if (!event) return null;
  return { id: event.ball, seed: event.seed, x: event.x, explicit: event.explicit_x };
}

/** One room, through reconnections. */
export class LiveTable {
  /** @type {Table | null} */
  table = null;
  #refs = 0;
  /** Drops asked for and not yet settled, by ref. */
  #mine = new Map();
  #state = "connecting";
  /** Room events heard of so far, and how the server knows us again. */
  #seq = 0;
  #last = null;
  /** Drops of ours that were under way when the line broke. */
  #adrift = [];

  /**
   * @param {string} room
   * @param {LiveListener} listener
   * @param {string} [stream] "segments" for pieces of paths instead of snapshots
   */
  constructor(room, listener, stream = "") {
    this.room = room;
    this.listener = listener;
    this.connection = new Connection(socketUrl(room, stream), {
      onText: (text) => this.#read(() => {
        for (const event of decodeEvents(text)) this.#take(event);
      }),
      onBytes: (bytes) => this.#read(() => this.#picture(bytes)),
      onLost: (waitMs) => this.#lost(waitMs),
      onRefused: (reason) => this.#setState("closed", reason),
      // A ball that flies for long sends no pieces meanwhile.
      onQuiet: () => this.ping(),
    });
  }

  /**
   * @param {{seed: string | null, x: number | null, stake?: number}} ask
   * @returns {boolean} false when there is no line: nothing was sent
   */
  drop({ seed, x, stake: wanted = 1 }) {
    // Where others may knock the ball nothing is staked.
    const stake = this.hello?.mode === "interacting" ? 0 : wanted;
    const ref = `d${this.#refs}`;
    this.#refs += 1;
    const message = {
      type: "drop",
      ref,
      stake: Math.round(stake * MINOR_UNITS),
      ...(seed !== null && { seed }),
      ...(x !== null && { x }),
    };
    if (!this.table || !this.connection.send(message)) return false;
    this.#mine.set(ref, { ref, ball: null, stake });
    this.connection.expectNews(true);
    return true;
  }

  /** Drops of ours that the table has not answered yet. */
  get unanswered() {
    let count = 0;
    for (const { ball } of this.#mine.values()) count += ball === null;
    return count;
  }

  /** @param {number} nowMs @returns {number} table time to draw, s */
  time(nowMs) {
    return this.clock ? this.clock.renderTick(nowMs) / this.clock.rate : 0;
  }

  /**
   * Settles what is due: scores, histogram, messages.
   * @param {number} due table time up to which landings count, s
   * @param {number} nowMs local time
   */
  settle(due, nowMs) {
    this.#settleUntil(due, nowMs / 1000);
  }

  /** @returns {{x: number, y: number}[][]} the way our last ball took, as lines */
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

  /** A server that speaks another protocol will go on doing so: no use in coming back. */
  #read(message) {
    try {
      message();
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.connection.close();
      this.#setState("closed", `This page does not understand the server: ${error.message}.`);
    }
  }

  #take(event) {
    if (COUNTED.has(event.type)) this.#seq += 1;
    const handlers = {
      hello: () => this.#hello(event),
      missed: () => this.#reclaim(event.events ?? []),
      accepted: () => this.#accepted(event),
      contact: () => this.table?.applyContact(event),
      landed: () => this.#landed(event),
      error: () => this.#refused(event),
      pong: () => this.listener.onPong?.(performance.now() - event.t),
    };
    // A newer server may send more kinds; what this page does not know it can do without.
    handlers[event.type]?.();
    this.listener.onChange();
  }

  #hello(hello) {
    this.connection.settled();
    this.hello = hello;
    this.scale = {
      extent: hello.extent,
      velocityScale: hello.velocity_scale,
      spinScale: hello.spin_scale,
      rate: hello.tick_rate,
    };
    this.clock = new TickClock({ rate: hello.tick_rate });
    this.tick = hello.tick;
    this.table = new Table(hello);
    this.#learnAddress(hello);
    this.listener.onTable(hello, hello.stats.histogram);
    this.#resume(hello);
    this.#setState(this.table.flying ? "live" : "asleep");
    this.connection.expectNews(this.table.flying);
  }

  async #learnAddress(hello) {
    this.address = hello.board_digest;
    try {
      this.address = await boardAddress(hello);
    } catch (error) {
      this.listener.onError(`Replay links may not work: ${error.message}`);
    }
  }

  /** After a lost line: asks what we have missed of what became of our drops. */
  #resume(hello) {
    const last = this.#last;
    const since = this.#seq;
    this.#last = { run: hello.run, key: hello.key };
    this.#seq = hello.seq;
    // What is dropped from here on is not lost, whatever the answer says.
    this.#adrift = [...this.#mine.values()];
    if (this.#adrift.length === 0) return;
    if (last?.run) this.connection.send({ type: "resume", since, ...last });
    else this.#reclaim([]);
  }

  /** Our balls are still flying here, have landed meanwhile, or landed where their seed says. */
  #reclaim(missed) {
    const accepted = missed.filter(({ type }) => type === "accepted");
    const landed = missed.filter(({ type }) => type === "landed");
    for (const drop of this.#adrift) {
      drop.ball ??= ballOf(accepted.find(({ ref }) => ref === drop.ref));
      if (!drop.ball) {
        this.#mine.delete(drop.ref);
        this.listener.onError("The line broke before the table took a drop. Its stake is back.");
        continue;
      }
      const { seed, x, explicit } = drop.ball;
      const there = this.hello.balls.find((ball) => ball.seed === seed && ball.x === x);
      const end = landed.find(({ ball }) => ball === drop.ball.id);
      const flying = there && this.table.balls.get(there.ball);
      if (flying) {
        drop.ball = Object.assign(flying, { mine: true, explicit });
      } else if (end) {
        this.#mine.delete(drop.ref);
        const { bin, score, unsettled } = end;
        this.listener.onPlayed({
          ...this.#playedOf(drop.ball), stake: drop.stake, bin, score, unsettled,
        });
      } else {
        this.#recover(drop);
      }
    }
  }

  /** @param {{ref: string, ball: any}} drop landed while nobody told us */
  async #recover({ ref, ball, stake }) {
    this.#mine.delete(ref);
    if (this.hello.mode === "interacting") {
      this.listener.onError(`What became of seed ${ball.seed} is unknown: others knocked it.`);
      return;
    }
    try {
      const played = { ...this.#playedOf(ball), stake };
      const record = await getJson(dropPath(played));
      this.listener.onPlayed({ ...played, bin: record.bin, score: record.score });
    } catch (error) {
      this.listener.onError(`What became of seed ${ball.seed} is unknown: ${error.message}`);
    }
  }

  #accepted(event) {
    const drop = this.#mine.get(event.ref);
    if (!this.table.awake) this.clock.restart();
    this.clock.observe(event.tick, performance.now());
    const ball = this.table.accept(event, drop !== undefined);
    if (drop) drop.ball = ball;
    this.#setState("live");
    this.connection.expectNews(true);
  }

  #landed(event) {
    this.table?.applyLanded(event);
    // Nobody looks at a hidden tab, and it gets no frames: what landed there counts at once.
    if (document.visibilityState === "hidden") {
      const now = performance.now();
      this.#settleUntil(Number.POSITIVE_INFINITY, null);
      this.table?.forget(this.time(now), now / 1000);
    }
  }

  /** @param {number} due s @param {number | null} wall s; null lights nothing up */
  #settleUntil(due, wall) {
    if (!this.table) return;
    for (const ball of this.table.settle(due, wall)) this.#settled(ball);
    this.#rest();
  }

  #settled(ball) {
    const { bin, score, unsettled } = ball.landed;
    if (bin !== null) this.listener.onHit(bin);
    for (const [ref, drop] of this.#mine) {
      if (drop.ball !== ball) continue;
      this.#mine.delete(ref);
      this.listener.onPlayed({
        ...this.#playedOf(ball), stake: drop.stake, bin, score, unsettled,
      });
    }
  }

  #playedOf({ seed, x, explicit }) {
    const knocked = this.hello.mode === "interacting";
    return { board: this.address, name: this.hello.board_name, seed, x: explicit ? x : null, knocked };
  }

  #refused(event) {
    this.#mine.delete(event.ref);
    this.listener.onError(event.detail, event.code);
    if (this.table) this.#rest();
  }

  #picture(bytes) {
    if (!this.table) return;
    if (this.hello.stream === SEGMENTS) this.#pieces(bytes);
    else this.#snapshot(bytes);
    this.clock.observe(this.tick, performance.now());
    this.listener.onChange();
  }

  #pieces(bytes) {
    const frame = decodeSegments(bytes, this.scale);
    this.tick = frame.tick;
    this.#seq = frame.seq; // contacts are among them, which this stream does not tell
    this.table.applySegments(frame);
  }

  #snapshot(bytes) {
    this.snapshot = decodeSnapshot(bytes, this.scale, this.snapshot);
    this.tick = this.snapshot.tick;
    this.table.applySnapshot(this.snapshot);
    this.listener.onSnapshot?.();
  }

  #lost(waitMs) {
    this.#setState("reconnecting", `${Math.max(1, Math.round(waitMs / 1000))} s`);
  }

  /** Nothing in flight and nothing asked for: the line may be silent as long as it likes. */
  #rest() {
    let flying = false;
    let showing = false;
    for (const ball of this.table.balls.values()) {
      flying ||= !ball.landed;
      showing ||= !ball.settled;
    }
    if (flying || this.unanswered > 0 || this.#state === "reconnecting") return;
    this.connection.expectNews(false);
    if (!showing) this.#setState("asleep");
  }

  #setState(state, detail) {
    if (state === this.#state && detail === undefined) return;
    this.#state = state;
    this.listener.onState(state, detail);
  }
}
