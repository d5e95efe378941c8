import assert from "node:assert/strict";
import { test } from "node:test";
import { createField, numbersOf } from "../../src/controls/fields.js";
import { fire, openPage } from "../page.js";

openPage();

/** @param {any} description @param {object} [shown] */
function fake(description, shown = {}) {
  /** @type {any[]} */
  const done = [];
  const note =
    (/** @type {string} */ what) =>
    (/** @type {any[]} */ ...args) =>
      done.push([what, ...args]);
  const actions = { move: note("move"), set: note("set"), leave: note("leave") };
  const field = createField({ name: "it", label: "It", tip: "Tip", group: "", ...description }, actions);
  const state = { value: 3, bounds: null, family: null, idle: "", problem: "", isChanged: false };
  const show = (/** @type {object} */ more) =>
    field.update(/** @type {any} */ ({ ...state, ...shown, ...more }));
  show({});
  const inputs = /** @type {any} */ (field.element).querySelectorAll("input, select");
  return { field, inputs, done, show };
}

test("a slider shows what moves, means where it stops, and Escape takes it back", () => {
  const { inputs, done } = fake({ kind: "slider", low: 0, high: 10 });
  const [track, exact] = inputs;
  assert.deepEqual([track.value, exact.value], ["3", "3"]);
  fire(track, "pointerdown");
  track.value = "5";
  fire(track, "input");
  fire(track, "change");
  assert.deepEqual(done, [
    ["move", "it", 5],
    ["set", "it", 5],
  ]);
  track.value = "6";
  fire(track, "input");
  fire(track, "keydown", { key: "Escape" });
  assert.deepEqual(done.at(-1), ["leave", "it"]);
});

test("a slider that has an automatic value says so by its box", () => {
  const { inputs, done, show } = fake(
    { kind: "slider", automatic: "auto", automaticValue: null },
    { value: null },
  );
  const [track, exact, box] = inputs;
  assert.deepEqual([box.checked, track.disabled, exact.disabled], [true, true, true]);
  show({ value: 0.5 });
  assert.deepEqual([box.checked, track.disabled], [false, false]);
  box.checked = true;
  fire(box, "change");
  assert.deepEqual(done, [["set", "it", null]]);
});

test("a range has two ends in order, and may be tied", () => {
  const { inputs, done } = fake({ kind: "range", low: 0, high: 9, automatic: "tied" }, { value: [2, 5] });
  const [least, most, tied] = inputs;
  fire(least, "pointerdown");
  least.value = "8";
  fire(least, "input");
  fire(least, "change");
  assert.deepEqual(done, [
    ["move", "it", [5, 8]],
    ["set", "it", [5, 8]],
  ]);
  assert.equal(most.value, "5");
  tied.checked = true;
  fire(tied, "change");
  assert.deepEqual(done.at(-1), ["set", "it", null]);
});

test("what is typed counts when it is done; a result that comes meanwhile leaves it alone", () => {
  const { inputs, done, show } = fake({ kind: "number" });
  const [input] = inputs;
  input.value = "7";
  fire(input, "input");
  show({ value: 4 });
  assert.equal(input.value, "7");
  fire(input, "change");
  assert.deepEqual(done, [["set", "it", 7]]);
  input.value = "";
  fire(input, "change");
  assert.deepEqual(done.at(-1), ["leave", "it"]);
});

test("a decimal comma is one, and what is no number is refused until it is mended", () => {
  const { field, inputs, done, show } = fake({ kind: "number" });
  const [input] = inputs;
  const type = (/** @type {string} */ text) => {
    input.value = text;
    fire(input, "input");
    fire(input, "change");
  };
  type("1,5");
  assert.deepEqual(done, [["set", "it", 1.5]]);
  type("abc");
  show({ value: 4 });
  assert.deepEqual([done.length, input.value], [1, "abc"]);
  assert.match(field.element.textContent ?? "", /“abc” is no number/);
  assert.equal(field.element.classList.contains("swc-wrong"), true);
  fire(input, "keydown", { key: "Escape" });
  assert.deepEqual([done.at(-1)?.[0], field.element.classList.contains("swc-wrong")], ["leave", false]);
});

test("commas part numbers, unless something else does", () => {
  assert.deepEqual(numbersOf("1,2,3"), [1, 2, 3]);
  assert.deepEqual(numbersOf("0.5, 1.5"), [0.5, 1.5]);
  assert.deepEqual(numbersOf("0,5; 1,5"), [0.5, 1.5]);
  assert.deepEqual(numbersOf("0,5 1,5"), [0.5, 1.5]);
  assert.ok(Number.isNaN(numbersOf("1, x")[1]));
});

test("a list is numbers, however they are parted", () => {
  const { inputs, done } = fake({ kind: "list" }, { value: [1, 2] });
  assert.equal(inputs[0].value, "1, 2");
  inputs[0].value = "0.5; 3  4";
  fire(inputs[0], "change");
  assert.deepEqual(done, [["set", "it", [0.5, 3, 4]]]);
});

test("a choice and a box are meant at once", () => {
  const choice = fake({ kind: "choice", choices: [["a", "A"]] }, { value: "a" });
  choice.inputs[0].value = "b";
  fire(choice.inputs[0], "change");
  assert.deepEqual(choice.done, [["set", "it", "b"]]);
  const check = fake({ kind: "check" }, { value: true });
  assert.equal(check.inputs[0].checked, true);
  check.inputs[0].checked = false;
  fire(check.inputs[0], "change");
  assert.deepEqual(check.done, [["set", "it", false]]);
});

test("a choice that can't be made is disabled and says why", () => {
  const { inputs } = fake(
    {
      kind: "choice",
      choices: [
        ["a", "A", ""],
        ["b", "B", "not here"],
      ],
    },
    { value: "a" },
  );
  const options = [.../** @type {any} */ (inputs[0]).querySelectorAll("option")];
  assert.deepEqual(
    options.map((option) => [option.textContent, option.getAttribute("disabled") !== null]),
    [
      ["A", false],
      ["B: not here", true],
    ],
  );
});

test("what has no effect is disabled and says why; what is wrong says so", () => {
  const { field, inputs, show } = fake({ kind: "number" });
  const why = /** @type {any} */ (field.element).querySelector(".swc-why");
  show({ idle: "Only with superfacets" });
  assert.deepEqual([inputs[0].disabled, why.hidden, why.textContent], [true, false, "Only with superfacets"]);
  show({ problem: "Too large" });
  assert.deepEqual([inputs[0].disabled, why.textContent], [false, "Too large"]);
  assert.equal(field.element.classList.contains("swc-wrong"), true);
});
