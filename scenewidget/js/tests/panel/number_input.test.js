import assert from "node:assert/strict";
import { test } from "node:test";
import { createNumberInput, numberOf, stepped } from "../../src/panel/number_input.js";
import { fire, openPage } from "../page.js";

openPage();

test("a number may have a decimal point or a comma", () => {
  for (const [text, value] of /** @type {Array<[string, number]>} */ ([
    ...[
      ["1.5", 1.5],
      ["1,5", 1.5],
      [" 12 ", 12],
      ["-0,25", -0.25],
      ["−3", -3],
      [".5", 0.5],
      [",5", 0.5],
      ["1e-3", 0.001],
    ],
  ]))
    assert.equal(numberOf(text), value, text);
});

test("thousands may be parted, as far as nothing is left to guess", () => {
  for (const text of ["1,234,567.5", "1.234.567,5", "1 234 567,5", "1'234'567.5", "1234567,5"])
    assert.equal(numberOf(text), 1_234_567.5, text);
  assert.equal(numberOf("1,234"), 1.234);
  assert.equal(numberOf("12.345.678"), 12_345_678);
});

test("what isn't a number isn't taken for one", () => {
  for (const text of ["", "abc", "1,5,2", "1.5,2.3", "12a", "-", ",", "1..5", "0x10", "Infinity", "1,23,456"])
    assert.ok(Number.isNaN(numberOf(text)), text);
});

test("steps lie on a grid and within its ends", () => {
  assert.equal(stepped(0.31, { step: 0.1 }, 1), 0.4);
  assert.equal(stepped(0.1, { step: 0.1, low: 0 }, -1), 0);
  assert.equal(stepped(0, { step: 0.1, low: 0 }, -1), 0);
  assert.equal(stepped(9, { high: 9 }, 1), 9);
});

test("arrow keys step it, but not what is no number", () => {
  let steps = 0;
  const input = createNumberInput({ step: 0.5 }, { "aria-label": "C" }, () => steps++);
  input.value = "1,5";
  fire(input, "keydown", { key: "ArrowUp" });
  assert.deepEqual([input.value, steps], ["2", 1]);
  input.value = "x";
  fire(input, "keydown", { key: "ArrowDown" });
  fire(input, "keydown", { key: "5" });
  assert.deepEqual([input.value, steps], ["x", 1]);
});
