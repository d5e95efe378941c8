import assert from "node:assert/strict";
import { test } from "node:test";
import { makePartition, NONE } from "../../src/labels/partition.js";
import { segmentRows, sorted } from "../../src/labels/segment_rows.js";

const partition = makePartition(
  {
    faceAtom: new Uint32Array([0, 0, 1, 2, 3, 3, 3]),
    atomSegment: new Uint32Array([0, 1, 0, NONE]),
    atomPart: null,
    segmentColors: new Uint8Array([1, 2, 3, 40, 50, 60]),
  },
  -1,
);
const plain = { names: {}, groups: {}, confidence: null, hidden: null };

test("every face is in one row", () => {
  const rows = segmentRows(partition, plain);
  assert.deepEqual(
    rows.map(({ segment, faces }) => [segment, faces]),
    [
      [0, 3],
      [1, 1],
      [NONE, 3],
    ],
  );
  assert.deepEqual(
    rows.map(({ color }) => color),
    ["rgb(1 2 3)", "rgb(40 50 60)", ""],
  );
});

test("a row tells name, confidence and how much is hidden", () => {
  const context = {
    names: { 1: "chair" },
    groups: {},
    confidence: [0.5, 1],
    hidden: new Uint8Array([1, 1, 0, 0]),
  };
  const rows = segmentRows(partition, context);
  assert.deepEqual(
    rows.map(({ name, confidence, hidden }) => [name, confidence, hidden]),
    [
      ["", 0.5, "some"],
      ["chair", 1, "all"],
      ["", null, "none"],
    ],
  );
});

test("parts follow their whole, in the order of the others", () => {
  const rows = segmentRows(partition, { ...plain, groups: { 0: 1, 7: 1 } });
  const order = sorted(rows, { column: "faces", isDescending: true });
  assert.deepEqual(
    order.map(({ segment, whole }) => [segment, whole]),
    [
      [1, null],
      [0, 1],
      [NONE, null],
    ],
  );
});

test("rows sort by each column, what is unlabeled stays last", () => {
  const rows = [
    ["lamp", 5, 2, 0.9],
    ["", 7, 1, null],
    ["chair 10", 5, 3, 0.2],
    ["chair 9", 6, 0, 0.2],
  ].map(
    ([name, faces, area, confidence], segment) =>
      /** @type {import("../../src/labels/segment_rows.js").Row} */ ({
        ...{ segment, name, color: "", whole: null, faces, area, confidence, hidden: "none" },
      }),
  );
  rows.push({ ...rows[0], segment: NONE, faces: 99, area: 99 });
  const by = (
    /** @type {import("../../src/labels/segment_rows.js").Column} */ column,
    /** @type {boolean} */ isDescending,
  ) => sorted(rows, { column, isDescending }).map(({ segment }) => segment);
  assert.deepEqual(by("name", false), [3, 2, 0, 1, NONE]);
  assert.deepEqual(by("faces", true), [1, 3, 0, 2, NONE]);
  assert.deepEqual(by("faces", false), [0, 2, 3, 1, NONE]);
  assert.deepEqual(by("area", true), [2, 0, 1, 3, NONE]);
  assert.deepEqual(by("confidence", false), [2, 3, 0, 1, NONE]);
  assert.deepEqual(by("confidence", true), [0, 2, 3, 1, NONE]);
});
