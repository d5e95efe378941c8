import assert from "node:assert/strict";
import { test } from "node:test";
import { createPickedBar } from "../../src/panel/picked_bar.js";
import { control, fakeDispatcher, openPage } from "../page.js";

const body = openPage();

function fake() {
  const { send, take } = fakeDispatcher();
  const left = { n: 0 };
  const bar = createPickedBar(send, () => left.n++);
  body.append(/** @type {any} */ (bar.element));
  return { bar, take, left, press: (/** @type {string} */ name) => control(bar.element, name) };
}

test("what is picked can be split, named, hidden, isolated, framed and let go", () => {
  const { bar, take, press } = fake();
  bar.show({ text: "Segment 1", of: "part" });
  assert.deepEqual(
    [bar.element.hidden, press("Merge them").hidden, press("Split").hidden],
    [false, true, false],
  );
  for (const name of ["Split", "Frame", "Let go"]) press(name).click();
  assert.deepEqual(take(), [
    { kind: "act_on_picked", what: "split" },
    { kind: "act_on_picked", what: "frame" },
    { kind: "back" },
  ]);
});

test("a stroke can be merged, a hint only let go", () => {
  const { bar, take, press } = fake();
  bar.show({ text: "Brush", of: "stroke" });
  assert.deepEqual([press("Merge them").hidden, press("Split").hidden], [false, true]);
  press("Merge them").click();
  assert.deepEqual(take(), [{ kind: "finish" }]);
  bar.show({ text: "Cut", of: "hint" });
  assert.deepEqual([press("Merge them").hidden, press("Split").hidden], [true, true]);
});

test("the focus doesn't go with the bar", () => {
  const { bar, left, press } = fake();
  bar.show({ text: "Segment 1", of: "part" });
  press("Split").focus();
  bar.show({ text: null, of: "part" });
  assert.deepEqual([bar.element.hidden, left.n], [true, 1]);
});
