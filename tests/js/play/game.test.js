// The money on the page equals the ledger's, in whatever order its messages, faults and the player's presses come.

import assert from "node:assert/strict";
import { test } from "node:test";

import { balanceOf, GRANT, MINOR_UNITS, openDrops } from "../../../static/js/model/player/account.js";
import { Game } from "../../../static/js/play/game.js";
import { chance } from "../support.js";
import { Clock, Disk, install, ROOM, Server, settled, UNDELIVERED } from "./fake-table.js";

const GAMES = Number(process.env.GAMES ?? 100); // more of them by hand
const NEVER = Number.POSITIVE_INFINITY;
const KEEP = { how: "keep", factor: 1 };

/** A player's browser, with one or two tabs at one table. */
class World {
  said = [];
  tabs = [];
  faulty = false; // whether storage refused a write since the last reload

  constructor(seed) {
    this.random = chance(seed);
    this.clock = new Clock();
    this.server = new Server(this.random);
    this.disk = new Disk();
    this.browser = install(this);
  }

  pick(list) {
    return list[Math.floor(this.random() * list.length)];
  }

  /** Opens a tab, or the same tab again after a reload. */
  open(tab = { sockets: [] }) {
    this.browser.tab = tab;
    const game = new Game({ storage: this.disk.open(), solver: null, streams: ["snapshots"], room: ROOM });
    game.on("said", ({ text }) => this.said.push(text));
    // A socket belongs to the tab that opened it; a reconnect is opened by the same tab's timer.
    Object.assign(tab, { game });
    if (!this.tabs.includes(tab)) this.tabs.push(tab);
    return tab;
  }

  /** Closes the page of the only tab and opens it again. Timers end with the page. */
  reload() {
    for (const socket of [...this.server.sockets]) {
      socket.onclose = null; // nobody listens any more
      socket.end(UNDELIVERED);
    }
    this.clock.forget();
    this.browser.listeners.clear();
    this.open(this.tabs[0]);
  }

  /** One random step. */
  async step() {
    const { server, clock } = this;
    const { game } = this.pick(this.tabs);
    const socket = this.pick([...server.sockets]);
    const steps = {
      drop: () => {
        if (this.random() < 0.3) game.choose({ stake: this.pick([0.01, 0.3, 1, 2.5, 120]) });
        if (this.random() < 0.3) game.choose({ balls: this.pick([1, 5]) });
        game.drop();
      },
      practise: () => {
        game.choose({ seed: "7" });
        game.drop();
        game.choose({ seed: null });
      },
      again: () => {
        const staked = game.account.last.filter(({ practice }) => !practice);
        if (staked.length) game.again(this.pick(staked));
      },
      auto: () => {
        if (!game.auto) game.startAuto(16, 6, { win: 20, loss: 5, onWin: KEEP, onLoss: this.pick([KEEP, { how: "times", factor: 2 }]) });
      },
      stop: () => { if (this.random() < 0.2) game.stop("player"); },
      end: () => { if (this.random() < 0.5) game.room.fair.end(); },
      refill: () => game.refill(),
      accept: () => { if (socket && !socket.accepted) server.accept(socket); },
      serve: () => {
        if (socket?.accepted) server.serve(socket, this.pick(["", "", "", "", "", "", "refuse", "undecided", "reset"]));
      },
      deliver: () => socket?.deliver(),
      land: () => server.land(),
      draw: () => game.room.settle(Number.POSITIVE_INFINITY, clock.now),
      time: () => clock.next(),
      cut: () => {
        if (this.random() < 0.15) socket?.end(this.pick([UNDELIVERED, 1012]));
      },
      reset: () => { if (this.random() < 0.2) server.reset(); },
      full: () => { server.full = this.random() < 0.1; },
      silent: () => { server.silent = this.random() < 0.5; },
      disk: () => {
        this.disk.full = this.random() < 0.3;
        this.faulty ||= this.disk.full;
      },
      reload: () => { if (this.tabs.length === 1 && !this.faulty && this.random() < 0.2) this.reload(); },
      tab: () => { if (this.tabs.length < 2 && this.random() < 0.05) this.open(); },
    };
    const often = ["accept", "serve", "deliver", "deliver", "serve", "deliver", "land", "draw", "time", "time", "drop"];
    const name = this.pick([...Object.keys(steps), ...often, ...often, ...often]);
    steps[name]();
    await settled();
    this.check(name);
  }

  /** What holds at any time: nothing is booked that the ledger does not have, and nothing twice. */
  check(after) {
    for (const { game } of this.tabs) {
      const { account } = game.wallet;
      let [staked, paid] = [account.before.staked, account.before.paid];
      for (const [id, { drops, folded }] of Object.entries(account.sessions)) {
        staked += folded?.staked ?? 0;
        paid += folded?.paid ?? 0;
        for (const [number, { stake, payout }] of Object.entries(drops)) {
          const fact = this.server.sessions.get(id)?.drops[number];
          assert.equal(stake, fact?.stake, `after ${after}: the stake of drop ${number} of ${id}`);
          if (payout !== null) assert.equal(payout, fact.payout, `after ${after}: the payout of drop ${number} of ${id}`);
          staked += stake;
          paid += payout ?? 0;
        }
      }
      const granted = account.granted ?? account.grants * GRANT;
      assert.equal(balanceOf(account), granted + paid - staked, `after ${after}: the balance`);
      const held = Math.round(game.room.own.held * MINOR_UNITS);
      assert.equal(Math.round(game.account.balance * MINOR_UNITS), balanceOf(account) - held, `after ${after}: the balance shown`);
    }
  }

  /** Faults end; everything on its way arrives; every ball lands and is shown. */
  async rest() {
    const { server, clock, disk } = this;
    Object.assign(server, { full: false, silent: false });
    disk.full = false;
    for (const { game } of this.tabs) game.stop("player");
    const busy = () => server.flying.length > 0 || this.tabs.some(({ game }) =>
      game.busy || game.locked || game.room.own.count > 0 || game.wallet.open.length > 0)
      || [...server.sockets].some((socket) => !socket.accepted || socket.up.length || socket.down.length);
    const [soon, until] = [clock.now + 70_000, clock.now + 600_000]; // by then the page has asked for what it missed
    for (let rounds = 0; busy() || (clock.now < soon && clock.waits); rounds += 1) {
      assert.ok(clock.now < until && rounds < 5000, `it comes to rest: ${JSON.stringify(this.tabs.map(({ game }) => ({
        state: game.room.state, own: game.room.own.count, busy: game.busy, open: openDrops(game.wallet.account),
      })))}`);
      for (const socket of [...server.sockets]) {
        if (!socket.accepted) server.accept(socket);
        while (socket.up.length) server.serve(socket);
        while (socket.down.length || socket.closing !== undefined && server.sockets.has(socket)) socket.deliver();
        await settled();
      }
      server.land();
      for (const { game } of this.tabs) game.room.settle(Number.POSITIVE_INFINITY, clock.now);
      clock.next();
      this.browser.tell("storage");
      await settled();
    }
    this.check("rest");
    const { sums } = server;
    for (const { game } of this.tabs) {
      const { account } = game.wallet;
      const granted = account.granted ?? account.grants * GRANT;
      assert.equal(Math.round(game.account.balance * MINOR_UNITS), granted + sums.paid - sums.staked, "the balance is the ledger's");
      assert.deepEqual(
        [game.account.balls, Math.round(game.account.staked * MINOR_UNITS), Math.round(game.account.returned * MINOR_UNITS)],
        [sums.count, sums.settled, sums.paid], "the statistics are the ledger's",
      );
    }
  }
}

/** @param {number} seed @param {number} [steps] */
async function play(seed, steps = 250) {
  const world = new World(seed);
  world.open();
  await settled();
  for (let i = 0; i < steps; i += 1) await world.step();
  await world.rest();
  return world;
}

test("the balance is the ledger's, whatever happens in whatever order", async () => {
  let drops = 0;
  for (let seed = 0; seed < GAMES; seed += 1) {
    const world = await play(seed).catch((error) => { throw new Error(`seed ${seed}: ${error.message}`, { cause: error }); });
    drops += world.server.sums.count;
  }
  assert.ok(drops > 6 * GAMES, `${drops} drops in ${GAMES} games: the table was played at`);
});

/** One tab at the table, or more, connected, each with an open session. */
async function seated(seed = 1, count = 1) {
  const world = new World(seed);
  const tabs = Array.from({ length: count }, () => world.open());
  const [{ game }] = tabs;
  const flow = async (faults = "") => {
    for (let i = 0; i < 12; i += 1) {
      for (const socket of [...world.server.sockets]) {
        if (!socket.accepted) world.server.accept(socket);
        while (socket.up.length) world.server.serve(socket, faults);
        while (socket.down.length) socket.deliver();
      }
      await settled();
    }
  };
  await settled();
  await flow();
  assert.ok(game.room.fair.open);
  return { world, tabs, game, flow };
}

test("a drop on its way while the owner resets is not called lost, and is the player's own", async () => {
  const { world, game, flow } = await seated();
  game.drop();
  world.server.reset();
  const [socket] = world.server.sockets;
  while (socket.down.length) socket.deliver(); // the hello of the new run, before the drop has arrived
  await settled();
  assert.equal(game.room.own.unanswered, 1);
  await flow();
  assert.deepEqual(world.said, []);
  assert.deepEqual([...game.room.table.balls.values()].map(({ mine }) => mine), [true]);
  await world.rest();
  assert.match(world.said.at(-1), /staked 1\.00/);
});

test("each of two tabs finds the drops of its own session again after its line broke", async () => {
  for (const i of [0, 1]) {
    const { world, tabs, flow } = await seated(5, 2);
    assert.equal(world.server.sessions.size, 2);
    tabs[i].game.drop();
    const socket = [...world.server.sockets].find(({ up }) => up.some(({ type }) => type === "drop"));
    while (socket.up.length) world.server.serve(socket);
    socket.end(UNDELIVERED); // before it has the receipt
    await flow();
    await world.rest();
    assert.equal(world.server.sums.count, 1);
  }
});

test("a result that cannot be computed is asked of the ledger until it tells", async () => {
  const { world, game, flow } = await seated();
  game.drop();
  await flow();
  assert.equal(game.wallet.open.length, 1);
  world.server.silent = true;
  const [socket] = world.server.sockets;
  socket.end(UNDELIVERED);
  world.server.reset(); // the landing is not among what the page has missed
  while (world.server.sockets.size === 0) world.clock.next();
  await flow();
  assert.deepEqual([game.room.own.count, game.wallet.open.length], [0, 1]);
  await world.rest();
  assert.match(world.said.at(-1), /staked 1\.00/);
});

test("an auto-drop that a reset cut says so", async () => {
  const { world, game, flow } = await seated();
  game.startAuto(16, 3, { win: NEVER, loss: NEVER, onWin: KEEP, onLoss: KEEP });
  for (const fault of ["", "reset", "reset"]) {
    await flow(fault);
    while (game.auto && game.room.own.unanswered === 0) world.clock.next();
    await flow(fault);
  }
  await world.rest();
  assert.ok(world.said.some((text) => /^Auto was cut short: \d of 3 balls/.test(text)), world.said.join("\n"));
  assert.ok(world.said.some((text) => /^On triangle: \d balls?, staked/.test(text)), `the ledger has told: ${world.said.join("\n")}`);
});

test("an auto-drop of practice stakes nothing when stakes are taken again", async () => {
  const { world, game, flow } = await seated();
  let why = "unsealed";
  Object.defineProperty(game.room, "practice", { get: () => why });
  game.startAuto(16, NEVER, { win: NEVER, loss: NEVER, onWin: KEEP, onLoss: KEEP });
  await flow();
  why = null;
  for (let i = 0; i < 8; i += 1) {
    world.clock.next();
    await flow();
  }
  assert.equal(game.auto, null);
  await world.rest();
  assert.equal(world.server.sums.count, 0);
  assert.ok(world.said.includes("Auto stopped: 1 ball, practice"), world.said.join("\n"));
});

test("an auto-drop with stakes does not go on as practice", async () => {
  const { world, game, flow } = await seated();
  game.startAuto(16, NEVER, { win: NEVER, loss: NEVER, onWin: KEEP, onLoss: KEEP });
  await flow();
  Object.defineProperty(game.room, "practice", { get: () => "unsealed" });
  for (let i = 0; i < 8; i += 1) {
    world.clock.next();
    await flow();
  }
  assert.equal(game.auto, null);
  assert.deepEqual(world.server.flying.map(({ stake }) => stake), [100]);
});

test("a full room says so, and is entered when a place is free", async () => {
  const world = new World(2);
  world.server.full = true;
  const { game } = world.open();
  const arrive = async () => {
    for (const socket of [...world.server.sockets]) {
      if (!socket.accepted) world.server.accept(socket);
      while (world.server.sockets.has(socket) && (socket.down.length || socket.closing !== undefined)) socket.deliver();
    }
    await settled();
  };
  await arrive();
  assert.equal(game.room.state, "full");
  assert.equal(game.room.hello, null, "no practice on another board");
  assert.deepEqual(world.said, [], "a newcomer has dropped nothing");
  game.drop();
  assert.match(world.said.at(-1), /This table is full/);
  world.server.full = false;
  while (world.server.sockets.size === 0) world.clock.next();
  await arrive();
  assert.equal(game.room.state, "asleep");
});

test("a drop pressed while the page connects waits for the table, or is said to be refused", async () => {
  for (const full of [false, true]) {
    const world = new World(4);
    world.server.full = full;
    const { game } = world.open();
    game.drop();
    assert.deepEqual([world.said, game.locked], [[], true]);
    const [socket] = world.server.sockets;
    world.server.accept(socket);
    while (world.server.sockets.has(socket) && (socket.down.length || socket.closing !== undefined)) socket.deliver();
    await settled();
    world.server.full = false;
    world.clock.next(world.clock.now + 100);
    assert.equal(game.room.own.unanswered, full ? 0 : 1);
    await world.rest();
    assert.equal(world.server.sums.count, full ? 0 : 1);
    assert.match(world.said.at(-1), full ? /This table is full/ : /staked 1\.00/);
  }
});

test("an invalid field drops nothing", async () => {
  const { world, game } = await seated();
  let faulty = 0;
  game.on("faulty", () => { faulty += 1; });
  game.choose({ fault: "“abc” is not valid." });
  game.drop();
  game.startAuto(4, 5, { win: NEVER, loss: NEVER, onWin: KEEP, onLoss: KEEP });
  assert.deepEqual([faulty, game.busy, world.server.sums.count], [2, false, 0]);
});

test("balls in flight before a reload are announced, and their results reported", async () => {
  const { world, game, flow } = await seated();
  game.drop();
  await flow();
  world.reload();
  await flow();
  const { game: again } = world.tabs[0];
  assert.equal(world.said.at(-1), "1 ball of yours is still falling.");
  assert.deepEqual([again.falling, again.locked], [1, true]);
  await world.rest();
  assert.match(world.said.at(-1), /x: staked 1\.00, won/);
});

test("a repeat is practice for one ball, and 'again' takes the same stake", async () => {
  const { world, game, flow } = await seated();
  game.choose({ stake: 2.5 });
  game.drop();
  await flow();
  await world.rest();
  game.choose({ stake: 1 });
  const [first] = game.account.last;
  game.rehearse(first);
  await flow();
  assert.deepEqual([game.choice.seed, game.practice], [null, null]);
  await world.rest();
  assert.match(world.said.at(-1), /\(practice\)$/);
  game.again(first);
  await flow();
  await world.rest();
  assert.match(world.said.at(-1), /staked 2\.50/);
});

test("a ball with a chosen start is practice, and 'again' of an earlier one is staked", async () => {
  const { world, game, flow } = await seated();
  const before = game.account.balance;
  game.choose({ aim: 0.25 });
  assert.equal(game.practice, "aim");
  game.drop();
  await flow();
  await world.rest();
  game.choose({ aim: null });
  game.drop(0.5); // a click on the board
  await flow();
  await world.rest();
  const dropped = game.account.last.map(({ practice, aim }) => [practice, aim]);
  assert.deepEqual(dropped, [[true, 0.5], [true, 0.25]]);
  assert.equal(game.account.balance, before);
  game.again({ ...game.account.last[0], aim: 0.25, stake: 2 });
  await flow();
  await world.rest();
  assert.match(world.said.at(-1), /staked 2\.00/);
});

test("the page reports a damaged account once", () => {
  const world = new World(3);
  world.disk.open().setItem("plinko.account.1", "{");
  for (const told of [1, 1]) {
    const { game } = world.open();
    game.begin();
    assert.equal(world.said.filter((text) => /could not be read/.test(text)).length, told);
  }
});
