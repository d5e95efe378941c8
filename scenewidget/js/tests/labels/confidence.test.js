import assert from "node:assert/strict";
import { test } from "node:test";
import { atomTable } from "../../src/labels/atom_table.js";
import { confidenceColor, confidenceOf, meanConfidence } from "../../src/labels/confidence.js";
import { packColor } from "../../src/labels/palette.js";
import { makePartition, NONE } from "../../src/labels/partition.js";

const partition = makePartition(
  {
    faceAtom: new Uint32Array([0, 0, 0, 1, 2, 3]),
    atomSegment: new Uint32Array([0, 0, 1, NONE]),
    atomPart: null,
    segmentColors: null,
    atomConfidence: new Uint16Array([65535, 1, 0, 65535]),
  },
  -1,
);
partition.atomArea.set([3, 1, 1, 1]);

test("codes run from 1 to 65535, 0 is none", () => {
  assert.deepEqual([0, 1, 65535].map(confidenceOf), [null, 0, 1]);
});

test("the surer, the lighter", () => {
  const lightness = [0.5, 0.6, 0.7, 0.85, 1].map((value) => {
    const [red, green, blue] = confidenceColor(value);
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  });
  assert.deepEqual(
    lightness,
    [...lightness].sort((a, b) => a - b),
  );
  assert.equal(new Set(lightness).size, 5);
  assert.deepEqual(confidenceColor(0), confidenceColor(0.5));
  assert.ok(lightness[4] - lightness[0] > 90);
});

test("a segment's confidence is the mean over its area; without any, it has none", () => {
  assert.deepEqual(meanConfidence(partition), { 0: 0.75 });
});

test("atoms are coloured by their confidence", () => {
  const table = atomTable(partition, "confidence");
  assert.deepEqual([...table.slice(2, 4)], [packColor(...confidenceColor(1)), 1]);
  assert.deepEqual([...table.slice(6, 8)], [packColor(...confidenceColor(0)), 1]);
  assert.equal(table[11], 0); // no confidence
  assert.equal(table[15], 0); // no segment
});
