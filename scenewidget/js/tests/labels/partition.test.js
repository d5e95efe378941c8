import assert from "node:assert/strict";
import { test } from "node:test";
import { countSegments, describe, makePartition, NONE } from "../../src/labels/partition.js";

const arrays = {
  faceAtom: new Uint32Array([0, 0, 1, 2, 2, 2, 3]),
  atomSegment: new Uint32Array([0, 0, 1, NONE]),
  atomPart: new Uint32Array([5, 6, 7, NONE, 0, 0, 0, 0]), // two levels
  segmentColors: new Uint8Array([10, 20, 30, 40, 50, 60]),
};

test("a face has the part of the chosen level, its segment and their sizes", () => {
  const fine = makePartition(arrays, 0);
  assert.deepEqual(describe(fine, 2), { part: 6, segment: 0, partFaces: 1, segmentFaces: 3, segmentArea: 0 });
  assert.deepEqual(describe(makePartition(arrays, 1), 4), {
    part: 0,
    segment: 1,
    partFaces: 7,
    segmentFaces: 3,
    segmentArea: 0,
  });
});

test("without levels the segments are the parts", () => {
  const partition = makePartition({ ...arrays, atomPart: null }, -1);
  assert.deepEqual(describe(partition, 3), {
    part: 1,
    segment: 1,
    partFaces: 3,
    segmentFaces: 3,
    segmentArea: 0,
  });
});

test("areas are those of the faces", () => {
  const mesh = {
    vertices: new Float32Array([0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4]),
    faces: new Uint32Array([0, 1, 2, 0, 1, 3]),
  };
  const faceAtom = new Uint32Array([0, 1]);
  const atomSegment = new Uint32Array([0, 0]);
  const partition = makePartition({ faceAtom, atomSegment, atomPart: null, segmentColors: null }, -1, mesh);
  assert.deepEqual([...partition.atomArea], [3, 4]);
  assert.equal(describe(partition, 1).segmentArea, 7);
});

test("unlabeled atoms are no segment", () => {
  assert.equal(countSegments(arrays.atomSegment), 2);
});
