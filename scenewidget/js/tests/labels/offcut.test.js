import assert from "node:assert/strict";
import { test } from "node:test";
import { divided, facesOf } from "../../src/labels/offcut.js";

test("faces come as bits from the first one on", () => {
  const bits = Uint8Array.of(0, 0b1001, 0b1);
  assert.deepEqual(facesOf(10, { buffer: bits.buffer, byteOffset: 1, byteLength: 2 }), [10, 13, 18]);
});

test("a divided atom becomes two that differ in their segment alone", () => {
  const tables = {
    faceAtom: Uint32Array.of(0, 0, 1, 1, 2),
    atomSegment: Uint32Array.of(7, 7, 4),
    atomPart: Uint32Array.of(1, 2, 3, 11, 12, 13),
    segmentColors: Uint8Array.of(1, 2, 3),
    atomConfidence: Uint16Array.of(5, 6, 0),
  };
  assert.deepEqual(divided(tables, [1, 2, 3], 8), {
    faceAtom: Uint32Array.of(0, 3, 4, 4, 2),
    atomSegment: Uint32Array.of(7, 7, 4, 8, 8),
    atomPart: Uint32Array.of(1, 2, 3, 1, 2, 11, 12, 13, 11, 12),
    segmentColors: tables.segmentColors,
    atomConfidence: Uint16Array.of(5, 6, 0, 5, 6),
  });
  assert.equal(divided({ ...tables, atomPart: null, atomConfidence: null }, [1], 8).atomPart, null);
});
