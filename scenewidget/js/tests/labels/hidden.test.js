import assert from "node:assert/strict";
import { test } from "node:test";
import { carried, facesOf } from "../../src/labels/hidden.js";

const coarse = { faceAtom: Uint32Array.of(0, 0, 1, 1, 2), atomSegment: Uint32Array.of(0, 1, 1) };
const fine = { faceAtom: Uint32Array.of(0, 3, 1, 1, 2), atomSegment: Uint32Array.of(0, 1, 1, 2) };

test("what is hidden stays hidden when atoms become finer", () => {
  const hidden = Uint8Array.of(1, 0, 1);
  assert.deepEqual(carried(hidden, coarse, fine), Uint8Array.of(1, 0, 1, 1));
  assert.equal(carried(hidden, coarse, { ...coarse }), hidden);
  assert.equal(carried(null, coarse, fine), null);
  assert.equal(carried(hidden, coarse, null), null);
});

test("one face tells of each hidden atom", () => {
  assert.deepEqual(facesOf(Uint8Array.of(1, 0, 1), coarse.faceAtom), [0, 4]);
  assert.deepEqual(facesOf(null, coarse.faceAtom), []);
});
