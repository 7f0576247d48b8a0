// Published test vectors of the algorithms that fair sessions use, and those of Stake.

import assert from "node:assert/strict";
import test from "node:test";

import { canonical } from "../../../static/js/fairness/canonical.js";
import { bytesOfHex, bytesOfText, hexOf, hmac, isSigned } from "../../../static/js/fairness/crypto.js";
import { isConsistent, isIncluded } from "../../../static/js/fairness/merkle.js";
import { payoutOf } from "../../../static/js/model/payout.js";
import { dropSeed, pick } from "../../../static/js/fairness/seeds.js";

const hex = (digits) => bytesOfHex(digits, "digits", digits.length / 2);

test("HMAC gives the vectors of RFC 4231", async () => {
  for (const [key, data, expected] of [
    [hex("0b".repeat(20)), "Hi There", "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7"],
    [bytesOfText("Jefe"), "what do ya want for nothing?",
      "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843"],
    [hex("aa".repeat(131)), "Test Using Larger Than Block-Size Key - Hash Key First",
      "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54"],
  ]) {
    assert.equal(hexOf(await hmac(key, bytesOfText(data))), expected);
  }
});

test("signatures verify as in RFC 8032", async () => {
  const key = hex("3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c");
  const signature = hex("92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da"
    + "085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00");
  assert.ok(await isSigned(key, signature, hex("72")));
  assert.ok(!(await isSigned(key, signature, hex("73"))));
});

test("HMAC gives Stake's vectors", async () => {
  for (const [server, client, nonce, path, bin] of [
    ["18e93f4a7b5b58d2569765766d1b6c3296bbd8430d6f20249044d72f14720159", "bb62964774", 1,
      "RRLRLLLLRLLLRLLL", 5],
    ["a9a09f7f84c9dc6d4f46f9b702d8e7e211e1fc219ac10e1145c4ca032eb000c6", "3c83fc7e07", 3,
      "LLRRLRLLLLLRLLRL", 5],
    ["a5022ccf5dd5a76d2014278e3d91d1dfc47c3f12e683ea0c8151fdc2f944beb1", "8b3ca8298c", 54,
      "RRLRLLLRLRRLLLLR", 7],
  ]) {
    const stream = [];
    for (const block of [0, 1]) {
      stream.push(...(await hmac(bytesOfText(server), bytesOfText(`${client}:${nonce}:${block}`))));
    }
    const found = Array.from({ length: 16 }, (_, i) => (stream[4 * i] >= 128 ? "R" : "L")).join("");
    assert.equal(found, path);
    assert.equal(found.replaceAll("L", "").length, bin);
  }
});

// The tree over the eight leaves of Certificate Transparency's tests.
const ROOT_6 = "76e67dadbcdf1e10e1b74ddc608abd2f98dfb16fbce75277b5232a127f2087ef";
const ROOT_8 = "5dc9da79a70659a9ad559cb701ded9a2ab9d823aad2f4960cfe370eff4604328";

test("proofs verify as in RFC 6962", async () => {
  const path = [
    "96a296d224f285c67bee93c30f8a309157f0daa35dc5b87e410b78630a09cfc7",
    "5f083f0a1a33ca076a95279832580db3e0ef4584bdff1f54c8a360f50de3031e",
    "6b47aaf29ee3c2af9af889bc1fb9254dabd31177f16232dd6aab035ca39bf6e4",
  ].map(hex);
  const tree = { index: 0, size: 8, root: hex(ROOT_8) };
  assert.ok(await isIncluded(hex(""), tree, path));
  assert.ok(!(await isIncluded(hex("00"), tree, path)));
  assert.ok(!(await isIncluded(hex(""), { ...tree, index: 1 }, path)));
  assert.ok(!(await isIncluded(hex(""), tree, path.slice(1))));
  const grown = [
    "0ebc5d3437fbe2db158b9f126a1d118e308181031d0a949f8dededebc558ef6a",
    "ca854ea128ed050b41b35ffc1b87b8eb2bde461e9e3b5596ece6b9d5975a0ae0",
    "d37ee418976dd95753c1c73862b9398fa2a2cf9b4ff0fdfe8b30cd95209614b7",
  ].map(hex);
  const [six, eight] = [{ size: 6, root: hex(ROOT_6) }, { size: 8, root: hex(ROOT_8) }];
  assert.ok(await isConsistent(six, eight, grown));
  assert.ok(!(await isConsistent({ ...six, root: hex(ROOT_8) }, eight, grown)));
  assert.ok(!(await isConsistent({ ...six, size: 5 }, eight, grown)));
  assert.ok(!(await isConsistent(six, eight, grown.slice(0, 2))));
});

test("a seed is the HMAC that docs/fairness.md defines", async () => {
  const known = { server: hex("01".repeat(32)), client: hex("02".repeat(32)), board: hex("03".repeat(32)) };
  const message = [..."plinko drop 1\n"].map((c) => c.charCodeAt(0));
  const whole = [...message, ...known.client, 0, 0, 0, 0, 0, 0, 0, 5, ...known.board];
  const mac = hexOf(await hmac(known.server, Uint8Array.from(whole)));
  assert.equal(await dropSeed(known, 5), String(BigInt(`0x${mac.slice(0, 16)}`)));
});

test("payouts are rounded down, and JSON is canonical", () => {
  assert.equal(payoutOf(10, 0.1), 1);
  assert.equal(payoutOf(3, 0.3), 0);
  assert.equal(payoutOf(100, 5.6), 560);
  assert.equal(payoutOf(1_000_000_000, 1e6), 1e15);
  assert.equal(payoutOf(1000, 1e-7), 0);
  assert.equal(canonical({ b: [1.0, null, "ä"], a: { d: true, c: -0 } }), '{"a":{"c":0,"d":true},"b":[1,null,"ä"]}');
});

test("a bin begins where the weights before it end", () => {
  const weights = [0, 3, 0, 2 ** 53 - 1, 0, 1, 0];
  const draw = { weights, seeds: weights.map((weight, bin) => (weight ? [`${bin}a`, `${bin}b`] : [])) };
  const sum = weights.reduce((total, weight) => total + BigInt(weight), 0n);
  const bytes = (x, y) => hex(x.toString(16).padStart(32, "0") + y.toString(16).padStart(32, "0"));
  const up = (place) => -((-(place << 128n)) / sum);
  const half = 1n << 63n;
  let before = 0n;
  for (const [bin, weight] of weights.entries()) {
    if (weight === 0) continue;
    const first = (before << 128n) % sum === 0n ? up(before) : up(before) + 1n;
    before += BigInt(weight);
    const next = (before << 128n) % sum === 0n ? up(before) : up(before) + 1n;
    assert.deepEqual(pick(draw, bytes(first, (half - 1n) << 64n)), { bin, seed: `${bin}a` });
    assert.deepEqual(pick(draw, bytes(next - 1n, half << 64n)), { bin, seed: `${bin}b` });
  }
});
