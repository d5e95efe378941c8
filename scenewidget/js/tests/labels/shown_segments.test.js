import assert from "node:assert/strict";
import { test } from "node:test";
import { NONE } from "../../src/labels/partition.js";
import { ShownSegments } from "../../src/labels/shown_segments.js";
import { fakeModel } from "../page.js";

/** Four faces, an atom each, two segments and a face without. */
function fake(state = {}) {
  const arrays = {
    face_atom: Uint32Array.of(0, 1, 2, 3),
    atom_segment: Uint32Array.of(0, 0, 1, NONE),
    atom_part: Uint32Array.of(5, 6, 7, NONE, 0, 0, 1, NONE),
    segment_colors: Uint8Array.of(10, 20, 30, 40, 50, 60),
  };
  const headers = Object.entries(arrays).map(([name, array]) => [
    name,
    { dtype: array instanceof Uint8Array ? "uint8" : "uint32", shape: [array.length] },
  ]);
  const model = fakeModel({
    ...Object.fromEntries(Object.entries(arrays).map(([name, { buffer }]) => [`_${name}`, buffer])),
    ...{ _headers: Object.fromEntries(headers), _token: "", _answers: {}, levels: ["base", "final"] },
    ...{ level: "final", segment_names: { 1: "chair" }, undo_title: "", redo_title: "" },
    ...state,
  });
  /** @type {any} */
  const shown = { mesh: null };
  const picture = {
    mesh: null,
    setPartition: (/** @type {any} */ partition) => {
      shown.partition = partition;
    },
  };
  let preview = /** @type {any} */ (null);
  const segments = new ShownSegments(model, /** @type {any} */ ({ tables: () => preview }), picture);
  segments.read();
  return {
    ...{ model, segments, shown },
    setPreview(/** @type {any} */ tables) {
      preview = tables;
      segments.read();
    },
  };
}

test("all parts that a suggested edit moves are one", () => {
  for (const [level, parts] of /** @type {const} */ ([
    ["base", [5, 6, 5, NONE]],
    ["final", [0, 0, 0, NONE]],
  ])) {
    const { segments, shown } = fake({ level });
    segments.suggested = [0, 2];
    segments.read();
    assert.deepEqual([...shown.partition.atomPart], parts);
    assert.deepEqual([...shown.partition.atomSegment], [0, 0, 1, NONE]);
  }
});

test("edits on their way show as done, and go when Python has answered", () => {
  const { model, segments, shown } = fake();
  assert.equal(segments.count, 2);
  const edit = /** @type {const} */ ({ kind: "merge", face: 0, onto_face: 2, level: "final" });
  const { client, number } = segments.pending.add(edit);
  segments.read();
  assert.equal(segments.count, 1);
  assert.equal(segments.undo, "Merge");
  assert.deepEqual([...shown.partition.atomSegment], [1, 1, 1, NONE]);
  model.set("_answers", { [client]: number });
  segments.read();
  assert.equal(segments.count, 2);
  assert.equal(segments.undo, null);
});

test("a sketch shows, but isn't told", () => {
  const { segments } = fake();
  segments.sketch = { kind: "merge", face: [0], onto_face: 2, level: "final" };
  segments.read();
  assert.equal(segments.count, 1);
  assert.equal(segments.pending.operations.length, 0);
});

test("an offcut is shown as a segment until the segments change", () => {
  const { segments, shown } = fake();
  segments.cutOff([1]);
  segments.read();
  assert.deepEqual([shown.partition.atomSegment[shown.partition.faceAtom[1]], segments.segmentOf(1)], [2, 0]);
  segments.pending.add({ kind: "split", face: 2, level: "base" });
  segments.cutOff([]);
  segments.read();
  assert.equal(segments.offcut, null);
});

test("while something else is shown for the moment there are no names and no edits", () => {
  const { segments, setPreview } = fake();
  assert.equal(segments.canCut(0, 1), true);
  assert.equal(segments.canCut(0, 2), false);
  setPreview({
    faceAtom: Uint32Array.of(0, 0, 0, 0),
    atomSegment: Uint32Array.of(0),
    segmentColors: new Uint8Array(3),
  });
  assert.deepEqual([segments.isPreview, segments.count, segments.names], [true, 1, {}]);
  assert.equal(segments.canCut(0, 1), false);
});

test("a face is told with its colour, a part of a finer level as such", () => {
  const { segments } = fake();
  const { text, color } = segments.descriptionOf(2);
  assert.match(text, /Segment 1 \(chair\)/);
  assert.equal(color, "rgb(40 50 60)");
  assert.equal(segments.titleOf({ face: 2, part: 1, segment: 1 }), "Segment 1 (chair)");
  assert.equal(segments.titleOf({ face: 0, part: 5, segment: 0 }), "Part of level final");
});

test("without arrays there is nothing to show", () => {
  const { model, segments, shown } = fake();
  model.set("_headers", {});
  segments.read();
  assert.deepEqual([shown.partition, segments.count], [null, 0]);
});
