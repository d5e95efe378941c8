import assert from "node:assert/strict";
import { test } from "node:test";
import { panelState } from "../../src/panel/state.js";
import { fakeModel } from "../page.js";

function fake(changes = {}) {
  const model = fakeModel({
    ...{ color_by: "segments", values_legend: {}, notices: ["own"], status: "Done", busy: false },
    ...{ mode: "edit", editable: true, ...changes },
  });
  const view = {
    mesh: { faces: { length: 15 }, colors: null },
    partition: null,
    hidden: null,
    lengths: [1, 2, 3],
  };
  const segments = { undo: null, redo: null, pending: { operations: [{}] } };
  return { around: /** @type {any} */ ({ model, view, segments }), segments };
}
const more = { tool: /** @type {const} */ ("merge"), isLive: true, notices: /** @type {any[]} */ (["gone"]) };

test("before the first edit one is told how, instead of what there is", () => {
  const { around, segments } = fake();
  const first = panelState(around, more);
  assert.match(first.summary, /Drag a part onto another/);
  assert.equal(first.status, "");
  segments.undo = /** @type {any} */ ("Merge");
  const later = panelState(around, more);
  assert.deepEqual([later.summary, later.status, later.undo], ["5 faces", "Done", "Merge"]);
  assert.equal(panelState(fake({ mode: "navigate" }).around, more).summary, "5 faces");
});

test("without a kernel nothing can be edited, and nothing is offered that it would have to do", () => {
  assert.deepEqual(panelState(fake().around, more).notices, ["gone", "own"]);
  const state = panelState(fake().around, { ...more, isLive: false });
  assert.deepEqual([state.editable, state.notices, state.pending], [false, ["gone"], 1]);
});

test("without a kernel nothing is computed, whatever it said last", () => {
  const { around } = fake({ busy: true, status: "Distances", mode: "navigate" });
  const computing = panelState(around, more);
  assert.deepEqual([computing.busy, computing.status], [true, "Distances"]);
  const gone = panelState(around, { ...more, isLive: false });
  assert.deepEqual([gone.busy, gone.status], [false, ""]);
});
