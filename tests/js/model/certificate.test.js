// Certificates in words, and where two proven paths part.

import assert from "node:assert/strict";
import test from "node:test";

import { partingOf, partingWords, provenWords } from "../../../static/js/model/certificate.js";

/** @typedef {import("../../../static/js/model/certificate.js").Certificate} Certificate */

/** @type {Certificate} */
const PROVEN = {
  certified: true, bin: 3, unsettled: null, undecided: null,
  x_end: { low: 1, high: 1.1, text: "[1.05 +/- 0.05]" },
  duration: { low: 4, high: 4.5, text: "[4.2 +/- 0.3]" },
  impacts: 2, bits: 160, comparisons: 435, ties: [], agrees: true,
  events: [[0, 7, 1, 0, 0.5, 1e-20], [0, 9, 2, 0.3, 1, 1e-18], [5, 3, 4.2, 1.05, 5, 1e-17]],
};

test("a proven bin is shown with its enclosure and cost", () => {
  const words = provenWords(PROVEN);
  assert.equal(words, "Certified: bin 3, x = [1.05 +/- 0.05] m after [4.2 +/- 0.3] s; "
    + "435 comparisons, each decided with 160 bits. Double precision agrees.");
  assert.match(provenWords({ ...PROVEN, agrees: false }), /Double precision differs/);
  assert.match(provenWords({ ...PROVEN, bin: null, unsettled: "balanced" }), /no bin, balanced/);
  assert.match(provenWords({ ...PROVEN, ties: ["peg 0 and peg 1"] }), /instant: peg 0 and peg 1\./);
});

test("an undecided drop is not proven, and the words say why", () => {
  const open = { ...PROVEN, certified: false, bin: null, undecided: "whether peg 3 is hit" };
  assert.equal(provenWords(open), "Not proven. Undecided: whether peg 3 is hit.");
  assert.equal(partingWords(PROVEN, open), provenWords(open));
});

test("two paths part where their events first differ", () => {
  /** @type {Certificate} */
  const other = { ...PROVEN, events: [[0, 7, 1, 3e-9, 0.5, 1e-20], [0, 8, 2, 0.3, 1, 1e-18]] };
  const parting = partingOf(PROVEN, other);
  assert.equal(parting?.common, 1);
  assert.equal(parting?.apart, 3e-9);
  assert.match(partingWords(PROVEN, other), /1 event is common to both, then the first hits peg 9, the second hits peg 8/);
  assert.equal(partingOf(PROVEN, PROVEN), null);
  assert.match(partingWords(PROVEN, PROVEN), /same way to the end, bin 3/);
});
