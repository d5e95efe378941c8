import assert from "node:assert/strict";
import { test } from "node:test";
import { NONE } from "../../src/labels/partition.js";
import { canMerge, foresee, NOTHING, replay } from "../../src/labels/prediction.js";

/** @typedef {import("../../src/labels/prediction.js").Operation} Operation */

// a face an atom; three automatic segments (0 0 1 1 2 -) of pairs at the finer level
const ground = {
  faceAtom: new Uint32Array([0, 1, 2, 3, 4, 5]),
  parts: {
    base: new Uint32Array([7, 8, 8, 9, 10, 11]),
    final: new Uint32Array([0, 0, 1, 1, 2, NONE]),
  },
};
const labels = { atomSegment: ground.parts.final, names: { 0: "floor", 2: "lamp" } };

/** @param {Operation[]} operations */
const after = (...operations) => {
  const { labels: shown, undo, redo } = replay(ground, labels, operations);
  return { segments: [...shown.atomSegment], names: shown.names, undo, redo };
};
const merge = (/** @type {number} */ face, /** @type {number} */ onto, level = "final") =>
  /** @type {const} */ ({ kind: "merge", face, onto_face: onto, level });
const split = (/** @type {number} */ face, level = "final") =>
  /** @type {const} */ ({ kind: "split", face, level });
/** @type {Operation} */
const undo = { kind: "undo" };
/** @type {Operation} */
const redo = { kind: "redo" };

test("a merge at the last level moves the whole segment as it is now", () => {
  assert.deepEqual(after(merge(2, 0)).segments, [0, 0, 0, 0, 2, NONE]);
  assert.deepEqual(after(merge(2, 0), merge(1, 4)).segments, [2, 2, 2, 2, 2, NONE]);
});

test("a merge at a finer level moves the part, wherever its faces are, unlabeled ones too", () => {
  assert.deepEqual(after(merge(1, 4, "base")).segments, [0, 2, 2, 1, 2, NONE]);
  assert.deepEqual(after(merge(5, 0, "base")).segments, [0, 0, 1, 1, 2, 0]);
});

test("a split at the last level takes off what was merged, at a finer one the part", () => {
  assert.deepEqual(after(merge(2, 0), split(2)).segments, [0, 0, 3, 3, 2, NONE]);
  assert.deepEqual(after(split(1, "base")).segments, [0, 3, 3, 1, 2, NONE]);
});

test("what changes nothing is refused with a reason", () => {
  for (const edit of [merge(0, 1), merge(0, 5), merge(5, 0), split(0), split(5)]) {
    assert.equal(typeof foresee(ground, labels, edit), "string");
  }
  assert.deepEqual(
    [merge(0, 1), merge(0, 5), merge(0, 2)].map((edit) => canMerge(ground, labels, edit)),
    [false, false, true],
  );
  assert.equal(typeof foresee(ground, labels, { kind: "relabel", face: 0, name: "floor" }), "string");
  assert.equal(typeof foresee(ground, labels, { kind: "relabel", face: 5, name: "x" }), "string");
  assert.equal(typeof foresee(ground, labels, { kind: "group", face: [5], onto_face: 0 }), "string");
  assert.deepEqual(foresee(ground, labels, { kind: "group", face: [2], onto_face: 0 }), labels);
});

test("a name goes on with the segment that takes the last of its faces, unless that has one", () => {
  assert.deepEqual(after(merge(4, 2)).names, { 0: "floor", 1: "lamp" });
  assert.deepEqual(after(merge(4, 0)).names, { 0: "floor" });
  assert.deepEqual(after({ kind: "relabel", face: 3, name: "sofa" }).names, {
    0: "floor",
    1: "sofa",
    2: "lamp",
  });
  assert.deepEqual(after({ kind: "relabel", face: 0, name: "" }).names, { 2: "lamp" });
});

test("undo and redo walk through the edits that are still on their way", () => {
  assert.deepEqual(after(merge(2, 0), undo).segments, [...labels.atomSegment]);
  assert.equal(after(merge(2, 0), undo).redo, "Merge");
  assert.deepEqual(after(merge(2, 0), split(2), undo, undo, redo).segments, [0, 0, 0, 0, 2, NONE]);
  assert.deepEqual(after(merge(2, 0), split(2)).undo, "Split");
  assert.equal(after(merge(2, 0)).redo, NOTHING);
});

test("how far undo can go below them, Python knows", () => {
  assert.deepEqual([after().undo, after().redo], [undefined, undefined]);
  assert.deepEqual([after(undo).undo, after(undo).redo], ["", ""]);
  assert.deepEqual([after(undo, redo).undo, after(undo, redo).redo], [undefined, undefined]);
});

test("edits that don't apply any more are passed over", () => {
  assert.deepEqual(after(merge(0, 1), merge(2, 0)).segments, [0, 0, 0, 0, 2, NONE]);
});

test("a brush moves all its parts at once, those that belong to none are passed over", () => {
  /** @type {Operation} */
  const brush = { kind: "merge", face: [2, 4, 5], onto_face: 0, level: "final" };
  assert.deepEqual(after(brush).segments, [0, 0, 0, 0, 0, NONE]);
  assert.equal(after(brush).undo, "Merge 3 parts");
  assert.deepEqual(after({ ...brush, level: "base", face: [1, 3] }).segments, [0, 0, 0, 0, 2, NONE]);
  assert.equal(canMerge(ground, labels, { ...brush, face: [5] }), false);
});

test("a cut shows when Python has made it; what can't be cut is refused at once", () => {
  assert.deepEqual(after({ kind: "cut", face_a: 0, face_b: 1 }).segments, [...labels.atomSegment]);
  assert.equal(after({ kind: "cut", face_a: 0, face_b: 1 }).undo, "Cut");
  const cut = (/** @type {number} */ a, /** @type {number} */ b) =>
    foresee(ground, labels, { kind: "cut", face_a: a, face_b: b });
  assert.match(String(cut(0, 2)), /two points of the same segment/);
  assert.match(String(cut(0, 5)), /unlabeled/);
});
