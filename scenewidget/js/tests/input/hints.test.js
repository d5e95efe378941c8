import assert from "node:assert/strict";
import { test } from "node:test";
import { IDLE } from "../../src/input/gestures.js";
import { hintOf } from "../../src/input/hints.js";

const hit = { face: 1, part: 1, segment: 1 };
const segments = {
  titleOf: () => "Segment 1",
  names: { 1: "chair" },
  groups: {},
  offcut: /** @type {any} */ (null),
  noun: "face",
};
/** @param {object} gesture @param {"merge" | "brush" | "cut"} tool */
const hint = (gesture, tool, isSought = false, more = {}) =>
  hintOf({ gesture: { ...IDLE, ...gesture }, tool }, { ...segments, ...more }, isSought);

test("a picked part is told what a click does, and offers what can be done with it", () => {
  assert.deepEqual(hint({}, "merge"), { text: null, of: "part", isGrouped: false });
  assert.deepEqual(hint({ picked: hit }, "merge"), {
    text: "Segment 1: click what to merge it with",
    of: "part",
    isGrouped: false,
  });
  for (const groups of [{ 1: 3 }, { 5: 1 }]) {
    assert.equal(hint({ picked: hit }, "merge", false, { groups }).isGrouped, true);
  }
});

test("a stroke is counted, in whatever tool it was begun", () => {
  const stroke = (/** @type {number} */ n) => ({ stroke: { onto: hit, gathered: Array(n).fill(hit) } });
  assert.deepEqual(hint(stroke(0), "merge"), { text: "Brush: gather parts for Segment 1", of: "stroke" });
  assert.deepEqual(hint(stroke(1), "brush"), { text: "Brush: 1 part onto Segment 1", of: "stroke" });
  assert.deepEqual(hint(stroke(2), "cut"), { text: "Brush: 2 parts onto Segment 1", of: "stroke" });
  assert.equal(hint({}, "brush").of, "hint");
});

test("a cut is led from point to point", () => {
  assert.match(hint({}, "cut").text ?? "", /from one side of a segment to the other/);
  assert.match(hint({ picked: hit }, "cut").text ?? "", /^Segment 1 \(chair\): click the other side/);
  assert.match(hint({ picked: hit }, "cut", true).text ?? "", /looking for the cut/);
  const offcut = { nFaces: 1200 };
  assert.match(hint({ picked: hit }, "cut", false, { offcut }).text ?? "", /cuts 1,200 faces off/);
});
