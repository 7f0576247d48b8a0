// A server with one table and a ledger, its sockets, a browser's clock, timers and storage: all of it moves only when
// the test says so. A socket keeps the order of its messages, as TCP does; a cut loses those on their way.

import { createHash } from "node:crypto";

import { SafeStorage } from "../../../static/js/util/storage.js";
import { triangle } from "../support.js";

const BOARD = triangle();
const ROOM = "main";
export const MULTIPLIERS = BOARD.bins.multipliers;
const UNDELIVERED = 1006;

/** The browser's clock and timers. Time passes only by `next`. */
export class Clock {
  now = 1000;
  #timers = new Map();
  #count = 0;

  set(call, ms = 0) {
    this.#count += 1;
    this.#timers.set(this.#count, { due: this.now + ms, call });
    return this.#count;
  }

  clear(id) {
    this.#timers.delete(id);
  }

  /** Whether a timer is to run. */
  get waits() {
    return this.#timers.size > 0;
  }

  /** Timers that ran before a reload do not run after it. */
  forget() {
    this.#timers.clear();
  }

  /** Runs the timer that is due next, if it is due before `until`. @returns {boolean} whether there was one */
  next(until = Number.POSITIVE_INFINITY) {
    const [first] = [...this.#timers].sort(([, a], [, b]) => a.due - b.due);
    if (!first || first[1].due > until) return false;
    this.#timers.delete(first[0]);
    this.now = Math.max(this.now, first[1].due);
    first[1].call();
    return true;
  }
}

/** Storage of the browser, which a test can fill up. */
export class Disk {
  #kept = new Map();
  full = false;

  /** @returns {SafeStorage} as one page sees it */
  open() {
    const disk = this;
    return new SafeStorage(() => ({
      getItem: (key) => disk.#kept.get(key) ?? null,
      setItem: (key, value) => {
        if (disk.full) throw new Error("full");
        disk.#kept.set(key, value);
      },
      removeItem: (key) => disk.#kept.delete(key),
    }), () => {});
  }
}

/** A WebSocket whose two ends the test moves. */
export class Socket {
  static OPEN = 1;
  readyState = 0;
  onmessage = null;
  onclose = null;
  /** @type {object[]} on their way to the server */
  up = [];
  /** @type {string[]} on their way to the page */
  down = [];
  joined = new Set();

  constructor(server, tab) {
    this.server = server;
    this.tab = tab;
    server.sockets.add(this);
  }

  send(text) {
    this.up.push(JSON.parse(text));
  }

  close() {
    this.end(1000);
  }

  /** @param {number} code */
  end(code) {
    this.readyState = 3;
    this.server.sockets.delete(this);
    const close = this.onclose;
    this.onclose = null;
    this.up = [];
    this.down = [];
    close?.({ code, reason: "" });
  }

  /** The page receives one message. */
  deliver() {
    const text = this.down.shift();
    if (text !== undefined) this.onmessage?.({ data: text });
    if (this.closing !== undefined && this.down.length === 0) this.end(this.closing);
  }
}

/** The table's server. */
export class Server {
  sockets = new Set();
  /** @type {Map<string, {drops: object[]} & Record<string, any>>} */
  sessions = new Map();
  full = false;
  silent = false; // whether REST requests fail
  #runs = 0;
  #keys = 0;
  #balls = 0;
  tick = 0;
  /** @type {object[]} */
  flying = [];
  /** @type {{seq: number, event: object, key: string, ref: unknown}[]} */
  #recent = [];
  seq = 0;

  constructor(random) {
    this.random = random;
    this.#begin();
  }

  #begin() {
    this.run = `run-${this.#runs += 1}`;
    this.#recent = [];
    this.seq = 0;
    this.flying = [];
  }

  /** All sums of the ledger, minor units: stakes of all drops, payouts of those that have landed. */
  get sums() {
    const drops = [...this.sessions.values()].flatMap((session) => session.drops);
    const landed = drops.filter((drop) => drop.landed);
    return {
      count: landed.length,
      staked: drops.reduce((sum, { stake }) => sum + stake, 0),
      settled: landed.reduce((sum, { stake }) => sum + stake, 0),
      paid: landed.reduce((sum, { payout }) => sum + payout, 0),
    };
  }

  /** A socket opens; the server greets it, or refuses it for want of room. @param {Socket} socket */
  accept(socket) {
    socket.readyState = Socket.OPEN;
    socket.accepted = true;
    if (this.full) {
      this.#post(socket, { type: "error", code: "room-full", detail: "The room is full", ref: null });
      socket.closing = 1013;
      return;
    }
    socket.key = `key-${this.#keys += 1}`;
    this.#greet(socket);
  }

  #greet(socket) {
    this.#post(socket, {
      type: "hello", protocol: 2, room: ROOM, run: this.run, key: socket.key, board: BOARD, board_name: BOARD.name,
      board_digest: "b0", slots: [], mode: "independent", tick_rate: 60, tick: this.tick, seq: this.seq,
      stream: "snapshots", extent: {}, velocity_scale: 1, physics_version: 0,
      limits: { balls: 200, drops_per_second: 20 }, stats: { histogram: MULTIPLIERS.map(() => 0) },
      balls: this.flying.map(({ ball, seed, x, tick }) => ({ ball, seed, x, tick })),
    });
  }

  #post(socket, event) {
    socket.down.push(JSON.stringify(event));
  }

  /** The server carries out the next message of a socket. @param {Socket} socket @param {string} [fault] */
  serve(socket, fault) {
    const message = socket.up.shift();
    if (!message) return;
    const refuse = (code) => this.#post(socket, { type: "error", code, detail: code, ref: message.ref ?? null });
    const session = this.sessions.get(message.session);
    if (message.type === "session" && !message.session) this.#beginSession(socket, message);
    else if (message.type === "session") {
      if (session?.token !== message.token) refuse("unknown-session");
      else {
        socket.joined.add(message.session);
        this.#state(socket, session);
      }
    } else if (message.type === "open" && session) {
      session.open = true;
      this.#state(socket, session);
    } else if (message.type === "end" && session) {
      session.ended = true;
      const statement = { drops: session.drops.length };
      for (const each of this.sockets) {
        if (each.joined.has(message.session)) {
          this.#post(each, { type: "ended", session: message.session, server_seed: "00", statement });
        }
      }
    } else if (message.type === "drop") this.#drop(socket, message, session, refuse, fault);
    else if (message.type === "resume") this.#missed(socket, message);
    else if (message.type === "ping") this.#post(socket, { type: "pong", t: message.t });
    else if (message.type === "appear") this.#post(socket, { type: "presence", here: 1, you: 1, visitors: [{ visitor: 1 }] });
  }

  #beginSession(socket, { commitment }) {
    const id = `s${this.sessions.size}`;
    const statement = {
      session: id, room: ROOM, board_digest: "b0", client_commitment: commitment, server_commitment: "5e",
    };
    const session = { id, statement, token: `t-${id}`, open: false, ended: false, drops: [] };
    this.sessions.set(id, session);
    socket.joined.add(id);
    this.#state(socket, session, session.token);
  }

  #state(socket, { id, statement, open, ended, drops }, token = null) {
    this.#post(socket, {
      type: "session", session: id, statement, signature: "51", key: "4e", open, ended, drops: drops.length, token,
    });
  }

  #drop(socket, message, session, refuse, fault) {
    if (message.session !== undefined) {
      if (!session || !socket.joined.has(message.session)) return refuse("unknown-session");
      if (!session.open || session.ended) return refuse("session-state");
    }
    if (fault === "refuse") return refuse("ledger-unavailable");
    if (fault === "undecided") refuse("undecided");
    const ball = this.#balls += 1;
    const seed = String(ball * 7919);
    const bin = Math.floor(this.random() * (MULTIPLIERS.length + 0.2));
    const landing = bin < MULTIPLIERS.length ? { bin, score: MULTIPLIERS[bin] } : { bin: null, score: 1 };
    const stake = message.stake ?? 0;
    const fact = {
      ball, seed, x: 0.01 * (ball % 7), tick: this.tick, stake, ...landing, payout: Math.floor(stake * landing.score + 1e-6),
      landed: false,
    };
    if (session) {
      fact.receipt = {
        session: session.id, drop: session.drops.length, stake, room: ROOM, ball, seed, board_digest: "b0", aim: null,
      };
      session.drops.push(fact);
    }
    if (fault === "reset") { // the ledger has it, but the room was reset before its ball entered
      fact.landed = true;
      return refuse("room-reset");
    }
    this.flying.push(fact);
    const event = {
      type: "accepted", ball, seed, x: fact.x, explicit_x: false, tick: this.tick, ref: null,
      ...(message.aim !== undefined && { aim: message.aim }),
      ...(session ? { stake, receipt: { receipt: fact.receipt, index: ball, root: "aa", signature: "bb" } } : { practice: true }),
    };
    this.#announce(event, socket, message.ref);
    return undefined;
  }

  #announce(event, sender = null, ref = null) {
    this.seq += 1;
    this.#recent.push({ seq: this.seq, event, key: sender?.key ?? "", ref });
    for (const socket of this.sockets) {
      if (socket.key) this.#post(socket, socket === sender ? { ...event, ref } : event);
    }
  }

  #missed(socket, { run, since, key }) {
    const events = run !== this.run ? null : this.#recent.filter(({ seq }) => seq > since)
      .map(({ event, key: own, ref }) => (own && own === key ? { ...event, ref } : event));
    this.#post(socket, { type: "missed", since, until: this.seq, events });
  }

  /** The oldest ball lands. */
  land() {
    const fact = this.flying.shift();
    if (!fact) return;
    this.tick += 7;
    fact.landed = true;
    const { ball, bin, score } = fact;
    this.#announce({ type: "landed", ball, bin, score, t: (this.tick - fact.tick) / 60, x_end: 0, digest: `d${ball}` });
  }

  /** The owner resets the room: its balls land at once, and every client gets a new hello. */
  reset() {
    while (this.flying.length) this.land();
    this.#begin();
    for (const socket of this.sockets) if (socket.key) this.#greet(socket);
  }

  /** A reply of REST. @param {URL} url @param {RequestInit} options */
  reply({ pathname, searchParams }, { headers = {} } = {}) {
    if (this.silent) throw new TypeError("no connection");
    if (pathname === "/api/v1/boards" && searchParams.has("digest")) {
      return { boards: [{ name: "triangle-8", preset: true, digest: "b0" }] };
    }
    const drop = /^\/api\/v1\/drops\/[^/]+\/(\d+)$/.exec(pathname);
    if (drop) {
      const facts = [...this.sessions.values()].flatMap(({ drops }) => drops);
      const { bin, score, ball } = facts.find(({ seed }) => seed === drop[1]) ?? { bin: 0, score: MULTIPLIERS[0], ball: 0 };
      return { bin, score, digest: `d${ball}` };
    }
    const asked = /^\/api\/v1\/sessions\/(\w+)\/export$/.exec(pathname);
    const session = asked && this.sessions.get(asked[1]);
    if (!session || headers.authorization !== `Bearer ${session.token}`) return null;
    return {
      session: { statement: session.statement }, board: { name: BOARD.name }, end: session.ended ? {} : null,
      drops: session.drops.map(({ receipt, landed, bin, score, payout }) =>
        ({ receipt, result: landed ? { bin, score, payout, digest: "d" } : null })),
    };
  }
}

/** Lets everything run that has been promised. */
const setImmediateNow = globalThis.setImmediate;
export async function settled() {
  for (let i = 0; i < 3; i += 1) await new Promise((resolve) => { setImmediateNow(resolve); });
}

/**
 * Replaces the browser's globals.
 * @param {{clock: Clock, server: Server, random: () => number}} world
 */
export function install({ clock, server, random }) {
  const listeners = new Map();
  const target = {
    addEventListener: (type, call) => listeners.set(type, [...(listeners.get(type) ?? []), call]),
    removeEventListener: (type, call) => listeners.set(type, (listeners.get(type) ?? []).filter((one) => one !== call)),
  };
  const timers = { setTimeout: (call, ms) => clock.set(call, ms), clearTimeout: (id) => clock.clear(id) };
  const globals = {
    ...timers,
    window: { ...target, ...timers, location: { search: "", pathname: "/" }, history: { pushState: () => {} } },
    document: { ...target, baseURI: "http://table.test/", visibilityState: "visible" },
    WebSocket: class extends Socket {
      constructor() { super(server, world.tab); }
    },
    fetch: async (url, options) => {
      const body = server.reply(new URL(url), options);
      const text = JSON.stringify(body ?? { detail: "unknown" });
      return {
        ok: body !== null, status: body === null ? 404 : 200, statusText: "", headers: { get: () => "application/json" },
        text: async () => text, json: async () => body,
      };
    },
  };
  const world = { tab: null, listeners, tell: (type) => { for (const call of listeners.get(type) ?? []) call(); } };
  for (const [name, value] of Object.entries(globals)) {
    Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
  }
  Object.defineProperty(performance, "now", { value: () => clock.now, configurable: true });
  Math.random = random;
  Object.defineProperty(crypto, "getRandomValues", {
    value: (bytes) => bytes.map((_, i, all) => { all[i] = Math.floor(256 * random()); return all[i]; }), configurable: true,
  });
  Object.defineProperty(crypto.subtle, "digest", {
    value: async (_, bytes) => new Uint8Array(createHash("sha256").update(bytes).digest()).buffer, configurable: true,
  });
  return world;
}

export { ROOM, UNDELIVERED };
