import assert from "node:assert/strict";
import { test } from "node:test";
import {
  candidates,
  chosenRows,
  countStates,
  inSight,
  scrolledTo,
  spokenCount,
  spokenTime,
} from "../../src/workbench/queue.js";

/** @param {string} scan @param {Partial<import("../../src/workbench/queue.js").Row>} [more] */
const row = (scan, more = {}) => ({
  ...{ scan, state: /** @type {const} */ ("new"), doubt: 0, faces: 1, segments: 1, edits: 0, seconds: 0 },
  ...{ people: [], error: "", before: null, now: null, ...more },
});
const rows = [
  row("b", { doubt: 0.1, state: "done", people: ["Ann"] }),
  row("a", { doubt: 0.1 }),
  row("c", { doubt: null, state: "failed" }),
  row("d", { doubt: 0.4, state: "begun" }),
];
const names = (/** @type {Array<{ scan: string }>} */ some) => some.map(({ scan }) => scan).join("");

test("the most doubtful come first, ties by name, what has no doubt last", () => {
  assert.equal(names(chosenRows(rows, { state: "", text: "", order: "doubt" })), "dabc");
  assert.equal(names(chosenRows(rows, { state: "", text: "", order: "name" })), "abcd");
});

test("filters go by state, search by name and people", () => {
  assert.equal(names(chosenRows(rows, { state: "begun", text: "", order: "doubt" })), "d");
  assert.equal(names(chosenRows(rows, { state: "", text: "ANN b", order: "doubt" })), "b");
  assert.deepEqual(countStates(rows), { new: 1, begun: 1, review: 0, done: 1, failed: 1 });
});

test("next goes on behind the current one and begins again; before it there is only what is before", () => {
  assert.deepEqual(candidates(rows, "a", 1), ["d", "b"]);
  assert.deepEqual(candidates(rows, "d", -1), ["a", "b"]);
  assert.deepEqual(candidates(rows, "", 1), ["b", "a", "d"]);
  assert.deepEqual(candidates(rows, "", -1), []);
});

test("of five thousand rows only those in sight are drawn", () => {
  assert.deepEqual(inSight({ n: 5000, top: 6800, height: 340, rowHeight: 68 }), [97, 108]);
  assert.deepEqual(inSight({ n: 2, top: 0, height: 340, rowHeight: 68 }), [0, 2]);
  assert.deepEqual(inSight({ n: 0, top: 0, height: 340, rowHeight: 68 }), [0, 0]);
  assert.equal(scrolledTo(3, { top: 0, height: 340, rowHeight: 68 }), 0);
  assert.equal(scrolledTo(5, { top: 0, height: 340, rowHeight: 68 }), 68);
  assert.equal(scrolledTo(1, { top: 200, height: 340, rowHeight: 68 }), 68);
});

test("times and counts are short", () => {
  assert.deepEqual([50, 150, 7200].map(spokenTime), ["50 s", "3 min", "2.0 h"]);
  assert.deepEqual([950, 45_200, 3_400_000].map(spokenCount), ["950", "45 k", "3.4 M"]);
});
