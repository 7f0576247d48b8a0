// The page's side of a fair session: what it sends when, what it stores, and which messages it rejects.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { test } from "node:test";

import { showingToken } from "../../../static/js/net/session-token.js";
import { FairPlay } from "../../../static/js/play/fairness/fair-play.js";
import { storage } from "../support.js";

const HELLO = { board_digest: "b1", mode: "independent" };

/** A page at a table; the test sees and answers its messages. */
function visit(kept = storage()) {
  const sent = [];
  const told = { faults: [], refused: [], ended: [] };
  const news = {
    tell: (kind, value) => {
      if (kind === "ended") told.ended.push(value.heard);
      if (kind === "unsealed") told.refused.push(value);
    },
    say: (message) => told.faults.push(message),
  };
  const fair = new FairPlay("main", kept, news, (message) => { sent.push(message); return true; });
  return { fair, sent, told };
}

/** Waits until the page begins a session. @returns {Promise<string>} the page's commitment */
async function asked({ sent }) {
  while (sent.at(-1)?.commitment === undefined) await new Promise(setImmediate);
  return sent.at(-1).commitment;
}

function state(commitment, more = {}) {
  const statement = { session: "s1", room: "main", board_digest: "b1",
    client_commitment: commitment, server_commitment: "5e", ...more.statement };
  return { type: "session", session: "s1", signature: "51", key: "4e", open: false, drops: 0,
    ended: false, token: "t1", ...more, statement };
}

async function begun(at = visit()) {
  at.fair.greeted(HELLO);
  at.commitment = await asked(at);
  at.fair.told(state(at.commitment));
  at.fair.told(state(at.commitment, { open: true, token: null }));
  return at;
}

test("the seed is revealed after the commitment, and drops wait", async () => {
  const at = visit();
  at.fair.greeted(HELLO);
  assert.ok(at.fair.drop("d0", { stake: 100 }));
  const commitment = await asked(at);
  assert.deepEqual(at.sent.map(({ type }) => type), ["session"]);
  at.fair.told(state(commitment));
  const { type, seed } = at.sent.at(-1);
  assert.equal(type, "open");
  assert.equal(createHash("sha256").update(Buffer.from(seed, "hex")).digest("hex"), commitment);
  at.fair.told(state(commitment, { open: true, token: null }));
  assert.deepEqual(at.sent.at(-1), { type: "drop", ref: "d0", stake: 100, session: "s1" });
});

for (const [name, statement] of [
  ["another secret", { client_commitment: "00" }],
  ["another table", { room: "other" }],
  ["another board", { board_digest: "b2" }],
]) {
  test(`with ${name} in the statement the seed is not revealed`, async () => {
    const at = visit();
    at.fair.greeted(HELLO);
    at.fair.drop("d0", { stake: 100 });
    at.fair.told(state(await asked(at), { statement }));
    assert.deepEqual(at.sent.map(({ type }) => type), ["session"]);
    assert.deepEqual(at.told.refused, ["d0"]);
    assert.match(at.told.faults[0], /does not match this page/);
    assert.equal(at.fair.committed, "");
    assert.equal(at.fair.drop("d1", { stake: 100 }), false);
  });
}

test("after a reconnect another commitment is rejected", async () => {
  const kept = storage();
  const { commitment } = await begun(visit(kept));
  for (const [server, faults] of [["5e", 0], ["66", 1]]) {
    const again = visit(kept);
    again.fair.greeted(HELLO);
    assert.deepEqual(again.sent, [{ type: "session", session: "s1", token: "t1", ref: "session" }]);
    const statement = { server_commitment: server };
    again.fair.told(state(commitment, { open: true, token: null, statement }));
    assert.equal(again.told.faults.length, faults);
    assert.equal(again.fair.open, faults === 0);
  }
});

test("a session whose token is gone is not joined again: its results could not be read", async () => {
  const kept = storage();
  await begun(visit(kept));
  kept.removeItem("plinko.token.s1");
  const again = visit(kept);
  again.fair.greeted(HELLO);
  assert.deepEqual(again.sent, []);
  await asked(again);
  assert.deepEqual(again.sent.map(({ session }) => session), [undefined]);
});

test("an export contains what the page received", async () => {
  const at = await begun();
  const receipt = { receipt: { session: "s1", drop: 0 }, index: 4, root: "aa", signature: "bb" };
  at.fair.accepted({ receipt });
  at.fair.accepted({ receipt: { ...receipt, receipt: { session: "another", drop: 7 } } });
  const { statement } = state(at.commitment);
  at.fair.ended({ session: "s1", statement: { drops: 1 } });
  assert.deepEqual(at.told.ended,
    [{ heard: [receipt], heard_session: { statement, signature: "51" } }]);
});

test("several drops after the end begin one new session", async () => {
  const at = await begun();
  at.sent.length = 0;
  for (const ref of ["d0", "d1", "d2"]) at.fair.refused({ ref, code: "session-state" });
  await asked(at);
  await new Promise(setImmediate);
  assert.deepEqual(at.sent.map(({ type }) => type), ["session"]);
});

/** The table accepts a drop as number `drop` of its session. */
function accepted(drop, ref = `d${drop}`) {
  return { ref, receipt: { receipt: { session: "s1", drop }, index: drop, root: "aa", signature: "bb" } };
}

const kinds = ({ sent }) => sent.map(({ type, ref }) => (type === "drop" ? ref : type));

test("a drop waits for the next session while one ends", async () => {
  const at = await begun();
  at.sent.length = 0;
  at.fair.drop("d0", { stake: 100 });
  at.fair.end();
  at.fair.end();
  at.fair.drop("d1", { stake: 100 });
  assert.deepEqual(kinds(at), ["d0"], "it ends when all its drops are answered");
  at.fair.accepted(accepted(0));
  at.fair.refused({ ref: "other", code: "rate-limited" });
  assert.deepEqual(kinds(at), ["d0", "end"]);
  at.fair.ended({ session: "s1", statement: { drops: 1 } });
  const commitment = await asked(at);
  const next = { session: "s2", statement: { session: "s2" } };
  at.fair.told(state(commitment, next));
  at.fair.told(state(commitment, { ...next, open: true, token: null }));
  assert.deepEqual(kinds(at), ["d0", "end", "session", "open", "d1"]);
  assert.equal(at.sent.at(-1).session, "s2");
});

test("a session has at most a thousand drops", async () => {
  const at = await begun();
  at.fair.accepted(accepted(996));
  at.sent.length = 0;
  for (const ref of ["a", "b", "c", "d", "e"]) at.fair.drop(ref, { stake: 100 });
  assert.deepEqual(kinds(at), ["a", "b", "c"]);
  at.fair.accepted(accepted(997, "a"));
  at.fair.refused({ ref: "b", code: "rate-limited" });
  assert.deepEqual(kinds(at), ["a", "b", "c", "d"], "a refused drop frees its place");
  at.fair.accepted(accepted(998, "c"));
  assert.deepEqual(kinds(at), ["a", "b", "c", "d"]);
  at.fair.accepted(accepted(999, "d"));
  assert.deepEqual(kinds(at), ["a", "b", "c", "d", "end"]);
});

test("after a reload a full session ends, and another begins", async () => {
  const kept = storage();
  const { commitment } = await begun(visit(kept));
  const again = visit(kept);
  again.fair.greeted(HELLO);
  again.fair.told(state(commitment, { open: true, token: null, drops: 1000 }));
  assert.deepEqual(kinds(again), ["session", "end"]);
});

test("an end reported by a refused drop begins one session", async () => {
  const at = await begun();
  at.sent.length = 0;
  at.fair.drop("d0", { stake: 100 });
  at.fair.refused({ ref: "d0", code: "session-state" });
  const commitment = await asked(at);
  at.fair.ended({ session: "s1", statement: { drops: 0 } });
  await new Promise(setImmediate);
  at.fair.told(state(commitment));
  assert.deepEqual(kinds(at), ["d0", "session", "open"]);
  assert.deepEqual(at.told.faults, []);
});

test("a page that cannot make a seed says so and only practises", async (t) => {
  const { subtle } = crypto;
  t.after(() => Object.defineProperty(crypto, "subtle", { value: subtle, configurable: true }));
  Object.defineProperty(crypto, "subtle", { value: undefined, configurable: true });
  const at = visit();
  at.fair.greeted(HELLO);
  assert.equal(at.fair.drop("d0", { stake: 100 }), false);
  assert.deepEqual(at.sent, []);
  assert.match(at.told.faults[0], /https/);
});

test("a session's token is kept after its end, for the export", async () => {
  const kept = storage();
  const at = await begun(visit(kept));
  at.fair.ended({ session: "s1", statement: { drops: 0 } });
  await asked(at);
  assert.deepEqual(showingToken(kept, "s1").headers.authorization, "Bearer t1");
  assert.deepEqual(showingToken(kept, "s2"), {});
});
