// A connection reconnects: immediately when the server says that the room moved, after a wait when it was lost.
import assert from "node:assert/strict";
import { test } from "node:test";

/** @type {any[]} */
let sockets = [];

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

/** A connection over fake sockets, until the test `t` ends. */
async function connected(t) {
  const { WebSocket, window, document } = globalThis;
  sockets = [];
  const ears = { addEventListener() {}, removeEventListener() {}, visibilityState: "visible" };
  Object.assign(globalThis, { WebSocket: FakeSocket, window: ears, document: ears });
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
  t.after(() => {
    connection.close();
    Object.assign(globalThis, { WebSocket, window, document });
  });
  return { connection, lost, foreign };
}

test("a client whose room moved reconnects at once and silently", async (t) => {
  const { connection, lost } = await connected(t);
  connection.settled();
  sockets[0].onclose({ code: 1012, reason: "room-moved" });
  assert.equal(sockets.length, 2);
  assert.deepEqual(lost, []);
  connection.settled();
  sockets[1].onclose({ code: 1012, reason: "room-moved" });
  assert.equal(sockets.length, 3);
});

test("a client sent on repeatedly waits, as after a loss", async (t) => {
  const { lost } = await connected(t);
  sockets[0].onclose({ code: 1012, reason: "" });
  sockets[1].onclose({ code: 1012, reason: "" });
  assert.equal(sockets.length, 2);
  assert.equal(lost.length, 1);
});

test("a silent connection is considered lost", async (t) => {
  const { connection, lost } = await connected(t);
  connection.settled();
  sockets[0].onclose({ code: 1006, reason: "" });
  assert.equal(sockets.length, 1);
  assert.equal(lost.length, 1);
});

test("a server that speaks another protocol is not called again", async (t) => {
  const { lost, foreign } = await connected(t);
  const [socket] = sockets;
  socket.onmessage({ data: '{"type":"hello","protocol":1}' });
  assert.deepEqual([foreign.length, lost.length, sockets.length], [1, 0, 1]);
  assert.match(foreign[0], /protocol 1/);
  assert.equal(socket.onclose, null, "its close is no loss");
});
