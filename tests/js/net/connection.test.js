// A connection reconnects: immediately when the server says that the room moved, after a wait when it was lost.
import assert from "node:assert/strict";
import { afterEach, beforeEach, test } from "node:test";

/** @type {any[]} */
let sockets = [];
const kept = { ...globalThis };

class FakeSocket {
  static OPEN = 1;
  readyState = 1;
  /** @param {string} url */
  constructor(url) {
    this.url = url;
    sockets.push(this);
  }

  send() {}
  close() {}
}

beforeEach(() => {
  sockets = [];
  const ears = { addEventListener() {}, removeEventListener() {}, visibilityState: "visible" };
  Object.assign(globalThis, { WebSocket: FakeSocket, window: ears, document: ears });
});

afterEach(() => {
  const { WebSocket, window, document } = kept;
  Object.assign(globalThis, { WebSocket, window, document });
});

async function connected() {
  const { Connection } = await import("../../../static/js/net/connection.js");
  const { decodeEvents } = await import("../../../static/js/net/protocol.js");
  /** @type {number[]} */
  const lost = [];
  /** @type {string[]} */
  const foreign = [];
  const connection = new Connection("ws://here/ws/rooms/main", {
    onText: (text) => decodeEvents(text),
    onForeign: (reason) => foreign.push(reason),
    onBytes() {},
    onLost: (waitMs) => lost.push(waitMs),
    onRefused() {},
  });
  return { connection, lost, foreign };
}

test("a client whose room moved reconnects at once and silently", async () => {
  const { connection, lost } = await connected();
  connection.settled();
  sockets[0].onclose({ code: 1012, reason: "room-moved" });
  assert.equal(sockets.length, 2);
  assert.deepEqual(lost, []);
  connection.settled();
  sockets[1].onclose({ code: 1012, reason: "room-moved" });
  assert.equal(sockets.length, 3);
  connection.close();
});

test("a client sent on repeatedly waits, as after a loss", async () => {
  const { connection, lost } = await connected();
  sockets[0].onclose({ code: 1012, reason: "" });
  sockets[1].onclose({ code: 1012, reason: "" });
  assert.equal(sockets.length, 2);
  assert.equal(lost.length, 1);
  connection.close();
});

test("a silent connection is considered lost", async () => {
  const { connection, lost } = await connected();
  connection.settled();
  sockets[0].onclose({ code: 1006, reason: "" });
  assert.equal(sockets.length, 1);
  assert.equal(lost.length, 1);
  connection.close();
});

test("a server that speaks another protocol is not called again", async () => {
  const { lost, foreign } = await connected();
  const [socket] = sockets;
  socket.onmessage({ data: '{"type":"hello","protocol":1}' });
  assert.deepEqual([foreign.length, lost.length, sockets.length], [1, 0, 1]);
  assert.match(foreign[0], /protocol 1/);
  assert.equal(socket.onclose, null, "its close is no loss");
});
