// Numbers as visitors type them.

import assert from "node:assert/strict";
import { test } from "node:test";

import { decimalOf, readNumber } from "../../../static/js/util/number-text.js";

test("a comma and a point are both decimal signs, and no digit is lost", () => {
  for (const [text, number] of [
    ["0.5", "0.5"], ["0,5", "0.5"], [" 1,25 ", "1.25"], [",5", "0.5"], [".5", "0.5"], ["2,", "2"], ["2.", "2"], ["-0,5", "-0.5"],
    ["−0,5", "-0.5"], ["+3", "3"], ["1e-3", "1e-3"], ["1,5E−30", "1.5e-30"], ["2e+3", "2e3"], ["1,125", "1.125"],
    ["0,12345678901234567890", "0.12345678901234567890"],
  ]) {
    assert.equal(decimalOf(text), number, text);
    assert.equal(readNumber(text), Number(number), text);
  }
});

test("what is not a number is invalid", () => {
  for (const text of ["", " ", ",", ".", "-", "e5", "1,2,3", "1.2.3", "1,234.5", "1 2", "abc", "NaN", "Infinity", "1e999", "0x1", "٣", "1/3"]) {
    assert.equal(decimalOf(text), null, text);
    assert.equal(readNumber(text), null, text);
  }
});
