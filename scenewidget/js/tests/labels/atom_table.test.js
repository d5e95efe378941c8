import assert from "node:assert/strict";
import { test } from "node:test";
import { atomTable } from "../../src/labels/atom_table.js";
import { packColor } from "../../src/labels/palette.js";
import { makePartition, NONE } from "../../src/labels/partition.js";

const arrays = {
  faceAtom: new Uint32Array([0, 0, 1, 2, 2, 2, 3]),
  atomSegment: new Uint32Array([0, 0, 1, NONE]),
  atomPart: new Uint32Array([5, 6, 7, NONE, 0, 0, 0, 0]), // two levels
  segmentColors: new Uint8Array([10, 20, 30, 40, 50, 60]),
};

test("segments have the colours that Python chose, unlabeled atoms none", () => {
  const table = atomTable(makePartition(arrays, 0), "segments");
  assert.deepEqual([...table.subarray(0, 4)], [0, 5, packColor(10, 20, 30), 1]);
  assert.deepEqual([...table.subarray(12, 16)], [NONE, NONE, 0, 0]);
});

test("parts have colours of their own", () => {
  const table = atomTable(makePartition(arrays, 0), "parts");
  assert.notEqual(table[2], table[6]);
  assert.equal(
    atomTable(makePartition(arrays, 1), "parts")[14],
    atomTable(makePartition(arrays, 1), "parts")[2],
  );
});

test("hidden atoms are marked beside their colour", () => {
  const table = atomTable(makePartition(arrays, 0), "segments", new Uint8Array([0, 1, 0, 1]));
  assert.deepEqual([table[3], table[7], table[11], table[15]], [1, 3, 1, 2]);
});
