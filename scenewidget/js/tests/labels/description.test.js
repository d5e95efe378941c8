import assert from "node:assert/strict";
import { test } from "node:test";
import { counted, describeFace } from "../../src/labels/description.js";
import { makePartition, NONE } from "../../src/labels/partition.js";

const mesh = {
  vertices: new Float32Array([0, 0, 0, 2, 0, 0, 0, 3, 0]),
  faces: new Uint32Array([0, 1, 2, 0, 1, 2, 0, 1, 2]),
};
const partition = makePartition(
  {
    faceAtom: new Uint32Array([0, 1, 2]),
    atomSegment: new Uint32Array([0, 0, NONE]),
    atomPart: new Uint32Array([4, 5, NONE]),
    segmentColors: null,
  },
  0,
  mesh,
);
const context = { level: "base", names: { 0: "chair" }, confidence: new Float32Array([0.875]), noun: "face" };

test("a face is told with its segment, size, confidence and part", () => {
  assert.equal(
    describeFace(partition, 1, context),
    "Segment 0 (chair)  ·  2 faces  ·  6.0 m²  ·  confidence 0.88  ·  base part of 1 face",
  );
});

test("what isn't known is left out", () => {
  assert.equal(describeFace(partition, 2, context), "Unlabeled");
  assert.match(describeFace(partition, 0, { ...context, noun: "point" }), /2 points/);
  assert.equal(
    describeFace(partition, 0, { ...context, names: {}, confidence: null }),
    "Segment 0  ·  2 faces  ·  6.0 m²  ·  base part of 1 face",
  );
});

test("large numbers are grouped", () => {
  assert.equal(counted(1234567, "face"), "1,234,567 faces");
});
