import assert from "node:assert/strict";
import { test } from "node:test";
import { createEditCommands } from "../../src/input/edit_commands.js";
import { NONE } from "../../src/labels/partition.js";
import { Pending } from "../../src/labels/pending.js";
import { fakeDispatcher, fakeModel } from "../page.js";

/** Three faces, an atom each: two of segment 0, one without. */
function fake(state = {}) {
  const atomSegment = Uint32Array.of(0, 0, NONE);
  const ground = { faceAtom: Uint32Array.of(0, 1, 2), parts: { base: Uint32Array.of(1, 2, 3) } };
  const pending = new Pending("me");
  const segments = /** @type {any} */ ({
    ...{ ground, shown: { labels: { atomSegment, names: {} } }, pending, isPreview: false, sketch: null },
    ...{ level: "base", names: {}, segmentOf: (/** @type {number} */ face) => atomSegment[face] },
  });
  /** @type {any[]} */
  const hidden = [];
  const view = /** @type {any} */ ({
    ...{ size: { width: 80, height: 40 }, hidden: null, partition: { atomSegment } },
    segmentOf: (/** @type {number} */ face) => atomSegment[face],
    hide: (/** @type {any} */ isHidden) => hidden.push(isHidden && [0, 1, 2].map(isHidden)),
  });
  const model = fakeModel({ editable: true, mode: "edit", revision: 4, quick_names: ["chair"], ...state });
  const root = /** @type {any} */ ({ dataset: { live: "true" } });
  const dispatcher = fakeDispatcher();
  const around = { model, view, segments, root, ...dispatcher, signal: new AbortController().signal };
  createEditCommands({ ...around, target: () => 0 });
  return { model, view, segments, root, hidden, ...dispatcher };
}

test("an edit goes to Python with its number, and waits", () => {
  const { model, segments, send, take } = fake();
  send({ kind: "act", what: "split", face: 0, place: null });
  assert.deepEqual(model.sent, [
    { kind: "split", face: 0, level: "base", revision: 4, client: "me", number: 1 },
  ]);
  assert.equal(segments.pending.operations.length, 1);
  assert.equal(take("segments").length, 1);
});

test("what makes no sense is refused with the reason", () => {
  const { model, send, take } = fake();
  send({ kind: "edit", edit: { kind: "merge", face: 0, onto_face: 2, level: "base" } });
  assert.deepEqual(model.sent, []);
  assert.match(take("remark")[0].text, /no segment to join/);
});

test("nothing is edited in a preview, nor when the kernel is gone", () => {
  const { model, segments, root, send, take } = fake();
  segments.isPreview = true;
  for (const kind of ["undo", "redo"]) send({ kind });
  send({ kind: "go_to", n: 0 });
  send({ kind: "edit", edit: { kind: "split", face: 0, level: "base" } });
  assert.equal(take("remark").filter(({ text }) => /preview/.test(text)).length, 4);
  segments.isPreview = false;
  root.dataset.live = "false";
  send({ kind: "undo" });
  send({ kind: "edit", edit: { kind: "split", face: 0, level: "base" } });
  assert.deepEqual(model.sent, []);
});

test("a send that fails takes the edit back and says so", () => {
  const { model, segments, send, take } = fake();
  model.send = () => {
    throw new Error("no comm");
  };
  send({ kind: "undo" });
  assert.equal(segments.pending.operations.length, 0);
  assert.match(take("remark").at(-1).text, /kernel is gone/);
});

test("undo lets go of what the brush has gathered first", () => {
  const { model, segments, send, take } = fake();
  segments.sketch = {};
  send({ kind: "undo" });
  assert.deepEqual([take("let_go").length, model.sent.length], [1, 0]);
  segments.sketch = null;
  send({ kind: "undo" });
  assert.equal(model.sent[0].kind, "undo");
});

test("a name is asked for where there is a segment, and given with a key", () => {
  const { model, send, take } = fake();
  send({ kind: "act", what: "name", face: 1, place: null });
  const [asked] = take("ask_name");
  assert.deepEqual([asked.title, asked.name, asked.place], ["Segment 0", "", { x: 40, y: 20 }]);
  send({ kind: "act", what: "name", face: 2, place: null });
  assert.match(take("remark").at(-1).text, /no segment to name/);
  send({ kind: "quick_name", index: 0 });
  assert.equal(model.sent[0].name, "chair");
  send({ kind: "quick_name", index: 5 });
  send({ kind: "name", face: 0, name: "sofa" });
  assert.equal(model.sent.length, 2);
});

test("hiding stays on the page", () => {
  const { model, hidden, send, take } = fake();
  send({ kind: "act", what: "hide", face: 0, place: null });
  send({ kind: "act", what: "isolate", face: 0, place: null });
  send({ kind: "show_all" });
  assert.deepEqual(hidden, [[true, true, false], [false, false, true], null]);
  assert.equal(take("hidden").length, 3);
  assert.deepEqual(model.sent, []);
});
