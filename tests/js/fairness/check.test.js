// The page's checker of fair sessions: an honest session passes, and each forgery fails in the right step.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

import { checkSession } from "../../../static/js/fairness/check.js";
import { checkedExport, ExportError, readExport } from "../../../static/js/fairness/export.js";
import { openSolver } from "../../../static/js/solver/solver.js";
import { json } from "../support.js";

const HONEST = json("tests/golden/session.json");
const KERNELS = readFileSync(new URL("../../../static/js/solver/kernels.wasm", import.meta.url));
const solver = await openSolver(KERNELS);
const kernelDigest = HONEST.session.statement.kernel_digest;

async function failures(session, tools = {}) {
  const failed = new Set();
  for await (const step of checkSession(checkedExport(session), { solver, kernelDigest, ...tools })) {
    if (!step.ok) failed.add(step.name);
  }
  return failed;
}

test("an honest session passes", async () => {
  assert.deepEqual(await failures(HONEST, { key: HONEST.key }), new Set());
  assert.deepEqual(readExport(JSON.stringify(HONEST)), HONEST);
});

const FORGERIES = {
  "another server seed": [(s) => { s.server_seed = "ff".repeat(32); }, ["server-seed", "end-seed", "start"]],
  "a server seed drawn late": [(s) => {
    // The server signs again, but the player already has another statement.
    s.heard_session = s.session;
    s.session = { ...s.session, statement: { ...s.session.statement, server_commitment: "5".repeat(64) } };
  }, ["heard-session", "session", "server-seed"]],
  "a statement that the server never gave": [(s) => { s.heard_session.signature = "0".repeat(128); },
    ["heard-session"]],
  "another client seed": [(s) => { s.client_seed = "ff".repeat(32); }, ["client-seed", "start"]],
  "a skipped drop": [(s) => { s.drops.splice(1, 1); }, ["counter", "truncated"]],
  "a truncated log": [(s) => { s.drops.pop(); }, ["truncated"]],
  "a receipt denied": [(s) => {
    const { receipt, index, root, signature } = s.drops.pop();
    s.heard = [{ receipt, index, root, signature }];
  }, ["truncated", "heard"]],
  "a changed payout": [(s) => { s.drops[2].result.payout += 1; }, ["payout"]],
  "a result withheld": [(s) => { s.drops[2].result = null; }, ["result"]],
  "another path": [(s) => { s.drops[0].result.digest = "0".repeat(64); }, ["trajectory"]],
  "another bin": [(s) => { s.drops[0].result.bin += 1; }, ["outcome"]],
  "a changed stake": [(s) => { s.drops[0].receipt.stake = 100_000; }, ["receipt", "inclusion", "payout"]],
  "a changed table": [(s) => { s.board.bins.multipliers[0] += 1; }, ["board", "payouts", "start", "trajectory"]],
  "a bad signature": [(s) => { s.session.signature = "0".repeat(128); }, ["session"]],
  "another key": [(s) => { s.key = "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a"; },
    ["session", "heard-session", "head", "end", "receipt"]],
  "inconsistent heads": [(s) => { s.drops[2].root = s.drops[1].root; }, ["receipt", "consistency"]],
  "a foreign receipt": [(s) => { s.drops[0].receipt.session = "x"; }, ["receipt-session", "receipt", "inclusion"]],
  "no opening": [(s) => { s.server_seed = null; }, ["server-seed-open", "end-seed"]],
  "no end": [(s) => { s.end = null; }, ["end"]],
};

for (const [name, [forge, expected]] of Object.entries(FORGERIES)) {
  test(`${name} is found`, async () => {
    const session = structuredClone(HONEST);
    forge(session);
    const found = await failures(session);
    for (const each of expected) assert.ok(found.has(each), `${each} in ${[...found]}`);
    const allowed = new Set([...expected, "payout", "outcome"]);
    for (const each of found) assert.ok(allowed.has(each), `${each} was not forged`);
  });
}

const DRAWN = json("tests/golden/draw_session.json");

test("an honest session with a draw passes", async () => {
  assert.deepEqual(await failures(DRAWN), new Set());
  const texts = [];
  for await (const step of checkSession(checkedExport(DRAWN), { solver, kernelDigest })) texts.push(step.text);
  for (const text of ["step.draw", "step.drawn", "step.drawn-bin"]) assert.ok(texts.includes(text));
});

const DRAWN_FORGERIES = {
  "a lighter bin": [(s) => { s.draw.weights[0] -= 1; }, ["draw"]],
  "another list": [(s) => { s.draw.seeds[0].push(s.draw.seeds[0][0]); }, ["draw"]],
  "another board's draw": [(s) => { s.draw.board_digest = "0".repeat(64); }, ["draw"]],
  "no draw": [(s) => { delete s.draw; }, ["draw", "start"]],
  "the ball of another bin": [(s) => {
    const [{ receipt, result }] = s.drops;
    [receipt.seed] = s.draw.seeds.find((seeds, bin) => seeds.length > 0 && bin !== result.bin);
  }, ["receipt", "inclusion", "start", "drawn-bin", "trajectory", "outcome"]],
  "an aim": [(s) => { s.drops[0].receipt.aim = 0; }, ["receipt", "inclusion", "start"]],
  "a draw where none was": [(s) => { delete s.session.statement.draw_digest; },
    ["session", "heard-session", "draw"]],
};

for (const [name, [forge, expected]] of Object.entries(DRAWN_FORGERIES)) {
  test(`in a draw, ${name} is found`, async () => {
    const session = structuredClone(DRAWN);
    forge(session);
    const found = await failures(session);
    for (const each of expected) assert.ok(found.has(each), `${each} in ${[...found]}`);
    const moved = ["start", "drawn-bin", "trajectory", "outcome", "payout"];
    for (const each of found) assert.ok([...expected, ...moved].includes(each), `${each} was not forged`);
  });
}

test("a malformed draw is refused", () => {
  const refused = (change, message) => {
    const session = structuredClone(DRAWN);
    change(session.draw);
    assert.throws(() => checkedExport(session), (error) => error instanceof ExportError
      && message.test(error.message));
  };
  refused((draw) => { draw.kind = "plinko receipt"; }, /draw is not a plinko draw/);
  refused((draw) => { draw.more = 1; }, /draw has an unknown field more/);
  refused((draw) => { draw.weights[0] = 1.5; }, /draw\.weights\[0\] is 1\.5/);
  refused((draw) => { draw.weights[0] = 2 ** 53; }, /draw\.weights\[0\]/);
  refused((draw) => { draw.weights[1] = 1; }, /seeds for exactly the bins/);
  refused((draw) => { draw.weights.pop(); }, /seeds for exactly the bins/);
  refused((draw) => { draw.seeds[0][0] = "18446744073709551616"; }, /is not a seed/);
  refused((draw) => { draw.seeds[0][0] = 1; }, /is not a seed/);
});

const RESTORED = json("tests/golden/restored_session.json");
const FORMER = RESTORED.keys[0].statement.former;

test("a void session of a former key passes", async () => {
  for (const key of [RESTORED.key, FORMER]) assert.deepEqual(await failures(RESTORED, { key }), new Set());
  const texts = [];
  for await (const step of checkSession(checkedExport(RESTORED), { solver, kernelDigest })) texts.push(step.text);
  for (const text of ["step.keys", "step.void", "step.heard", "step.heard-void"]) assert.ok(texts.includes(text));
});

const RESTORED_FORGERIES = {
  "no change of the key": [(s) => { delete s.keys; }, ["session", "heard-session", "end", "receipt", "heard"]],
  "a change that the next key has not signed": [(s) => { s.keys[0].signature = "0".repeat(128); }, ["keys"]],
  "a change to another key": [(s) => { s.keys[0].statement.key = "ab".repeat(32); }, ["keys"]],
  "another seed of a void drop": [(s) => { s.heard[3].receipt.seed = "1"; }, ["heard"]],
  "an unsigned receipt of a void drop": [(s) => { s.heard[3].signature = "0".repeat(128); }, ["heard"]],
  "an end that is not void": [(s) => { delete s.end.statement.void; }, ["end", "heard"]],
  "the first log": [(s) => { delete s.head.statement.log; }, ["head", "receipt", "heard"]],
  "one drop fewer than the end has": [(s) => { s.drops.pop(); }, ["truncated"]],
};

for (const [name, [forge, expected]] of Object.entries(RESTORED_FORGERIES)) {
  test(`in a void session, ${name} is found`, async () => {
    const session = structuredClone(RESTORED);
    forge(session);
    assert.deepEqual([...await failures(session)].sort(), [...expected].sort());
  });
}

test("only a key that handed on its place is known by its successor", async () => {
  for (const signature of [null, "0".repeat(128)]) {
    const session = structuredClone(RESTORED);
    session.keys[0].former_signature = signature;
    assert.deepEqual(await failures(session, { key: RESTORED.key }), new Set());
    assert.deepEqual(await failures(session, { key: FORMER }), new Set(["key"]));
  }
});

test("another kernel and another server are found", async () => {
  assert.deepEqual(await failures(HONEST, { kernelDigest: "0".repeat(64) }), new Set(["kernel"]));
  assert.deepEqual(await failures(HONEST, { key: "0".repeat(64) }), new Set(["key"]));
});

test("a malformed export is refused, and the field named", async () => {
  const refused = (change, message) => {
    const session = structuredClone(HONEST);
    change(session);
    assert.throws(() => checkedExport(session), (error) => error instanceof ExportError
      && message.test(error.message));
  };
  refused((s) => { s.version = 2; }, /version 2 is not 1/);
  refused((s) => { s.extra = 1; }, /the export has an unknown field extra/);
  refused((s) => { s.drops[0].receipt.bonus = 1; }, /drops\[0\]\.receipt has an unknown field bonus/);
  refused((s) => { s.drops[0].receipt.drop = -1; }, /drops\[0\]\.drop is -1/);
  refused((s) => { delete s.head; }, /the export lacks head/);
  refused((s) => { s.drops[0].result.payout = 2 ** 53; }, /drops\[0\]\.result\.payout is 9007199254740992/);
  refused((s) => { s.drops[0].receipt.stake = 10n ** 18n; }, /drops\[0\]\.stake is "1000000000000000000"/);
  assert.throws(() => readExport("{"), ExportError);
  assert.throws(() => readExport("[]"), ExportError);
  const short = structuredClone(HONEST);
  short.server_seed = "00";
  await assert.rejects(failures(short), /server-seed "00" is not 64 hexadecimal digits/);
});

test("a stake that could pay more than readers keep is refused", async () => {
  const session = structuredClone(HONEST);
  session.board.bins.multipliers[0] = 1e9;
  session.drops[0].receipt.stake = 1e9;
  await assert.rejects(failures(session), (error) => error instanceof ExportError
    && error.message.startsWith("stake 1000000000 could pay more than 9007199254740991"));
});

for (const [part, place] of Object.entries({
  "": (s) => s, "board": (s) => s.board, "drops[0].result": (s) => s.drops[0].result,
  "session.statement": (s) => s.session.statement,
})) {
  test(`a member given twice is refused and named: ${part}`, () => {
    const session = structuredClone(HONEST);
    place(session).again = 1;
    place(session).more = 1;
    const text = JSON.stringify(session).replace('"more":1', '"again":1');
    const where = `${part && `${part}.`}again: the key is given twice`;
    assert.throws(() => readExport(text), (error) => error instanceof ExportError && error.message === where);
  });
}
