import assert from "node:assert/strict";
import { test } from "node:test";
import { differences, facesIn, finerTables, painted, rangesOf } from "../../src/labels/painting.js";
import { makePartition, NONE } from "../../src/labels/partition.js";
import { foresee, replay } from "../../src/labels/prediction.js";

// three atoms of two faces each; the last one is unlabeled
const ground = {
  faceAtom: new Uint32Array([0, 0, 1, 1, 2, 2]),
  parts: { base: new Uint32Array([7, 7, 8]) },
};
const labels = { atomSegment: new Uint32Array([0, 1, NONE]), names: { 0: "floor", 1: "mug" } };
const paint = (/** @type {number[]} */ faces, /** @type {number | null} */ onto) =>
  /** @type {const} */ ({ kind: "paint", ranges: rangesOf(faces), onto_face: onto });

/** Segment of each face. @param {...import("../../src/labels/prediction.js").Operation} operations */
function after(...operations) {
  const { labels: shown } = replay(ground, labels, operations);
  const { faceAtom } = shown.finer ?? ground;
  return { segments: [...faceAtom].map((atom) => shown.atomSegment[atom]), names: shown.names };
}

test("ranges hold each face once, in order", () => {
  assert.deepEqual(rangesOf([7, 3, 4, 5, 3]), [3, 6, 7, 8]);
  assert.deepEqual(rangesOf([100, 20, 3]), [3, 4, 20, 21, 100, 101]); // by number, not by letter
  assert.deepEqual([...facesIn([3, 6, 7, 8])], [3, 4, 5, 7]);
  assert.deepEqual(rangesOf([]), []);
});

test("painted faces join a segment or become one, whatever atoms they were in", () => {
  assert.deepEqual(after(paint([1, 4], 2)).segments, [0, 1, 1, 1, 1, NONE]);
  assert.deepEqual(after(paint([1], null)).segments, [0, 2, 1, 1, NONE, NONE]);
  assert.deepEqual(after(paint([0, 1], 2)), { segments: [1, 1, 1, 1, NONE, NONE], names: { 1: "mug" } });
});

test("what comes after a stroke is foreseen on the finer atoms", () => {
  const merge = /** @type {const} */ ({ kind: "merge", face: 1, onto_face: 2, level: "final" });
  assert.deepEqual(after(paint([1], null), merge).segments, [0, 1, 1, 1, NONE, NONE]);
  assert.deepEqual(after(paint([1], null), paint([0], 1)).segments, [2, 2, 1, 1, NONE, NONE]);
  assert.deepEqual(after(paint([1], null), { kind: "undo" }).segments, [0, 0, 1, 1, NONE, NONE]);
});

test("strokes that change nothing are refused", () => {
  assert.equal(foresee(ground, labels, paint([2, 3], 2)), "All of that is in this segment already");
  assert.match(String(foresee(ground, labels, paint([2], 5))), /unlabeled/);
});

test("tables follow the atoms, and Python's stay as they are", () => {
  const done = painted(ground, labels.atomSegment, [1, 3], 5);
  assert.ok(done);
  const tables = {
    ...{ faceAtom: ground.faceAtom, atomSegment: labels.atomSegment, atomPart: ground.parts.base },
    ...{ segmentColors: null, atomConfidence: new Uint16Array([10, 20, 30]) },
  };
  const finer = finerTables(tables, done.ground, ["base"]);
  assert.deepEqual([...(finer.atomPart ?? [])], [7, 7, 8, 7, 7]);
  assert.deepEqual([...(finer.atomConfidence ?? [])], [10, 20, 30, 10, 20]);
  assert.deepEqual([...ground.faceAtom], [0, 0, 1, 1, 2, 2]);
  makePartition(tables, 0); // measured once, it need not be measured again
  const again = painted(ground, labels.atomSegment, [1, 3], 5);
  assert.ok(again);
  const shown = makePartition(
    { ...finerTables(tables, again.ground, ["base"]), atomSegment: again.atomSegment },
    0,
  );
  assert.deepEqual([...shown.atomFaces], [1, 1, 2, 1, 1]);
});

test("a stroke that goes on keeps its table, and says what has changed in it", () => {
  const draft = { faceAtom: null };
  const first = painted(ground, labels.atomSegment, [1, 2], 5, draft)?.ground.faceAtom;
  assert.ok(first);
  assert.deepEqual([...first], [0, 3, 1, 1, 2, 2]);
  assert.deepEqual(differences(ground.faceAtom, first), [1, 2]);
  const next = painted(ground, labels.atomSegment, [2, 3], 5, draft)?.ground.faceAtom;
  assert.equal(next, first);
  assert.deepEqual([...first], [0, 0, 3, 1, 2, 2]); // what is in it no longer is as it was
  assert.deepEqual(differences(first, first), [1, 2, 2, 3]);
  assert.deepEqual(differences(first, ground.faceAtom), [2, 3]);
  assert.equal(differences(first, Uint32Array.of(0, 0, 1, 1, 2, 2)), null);
});

test("a stroke that waits for Python is copied once", () => {
  const ranges = [1, 3];
  const [first, again] = [0, 1].map(() => painted(ground, labels.atomSegment, ranges, 5)?.ground.faceAtom);
  assert.equal(first, again);
  assert.notEqual(painted(ground, labels.atomSegment, [1, 3], 5)?.ground.faceAtom, first);
});
