import assert from "node:assert/strict";
import { test } from "node:test";
import { carried, countHidden, facesOf, othersHidden, toggledHidden } from "../../src/labels/hidden.js";

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

const atomSegment = Uint32Array.of(0, 0, 1, 2);
/** @param {((atom: number) => boolean) | null} isHidden */
const marks = (isHidden) => isHidden && [...atomSegment].map((_, atom) => Number(isHidden(atom)));

test("a segment is hidden whole, then shown again, and others stay as they are", () => {
  assert.deepEqual(marks(toggledHidden(null, atomSegment, 0)), [1, 1, 0, 0]);
  assert.deepEqual(marks(toggledHidden(Uint8Array.of(1, 0, 0, 1), atomSegment, 0)), [1, 1, 0, 1]);
  assert.deepEqual(marks(toggledHidden(Uint8Array.of(1, 1, 0, 1), atomSegment, 0)), [0, 0, 0, 1]);
});

test("all others are hidden, and shown if that is so already", () => {
  assert.deepEqual(marks(othersHidden(Uint8Array.of(1, 1, 1, 1), atomSegment, 1)), [1, 1, 0, 1]);
  assert.equal(othersHidden(Uint8Array.of(1, 1, 0, 1), atomSegment, 1), null);
});

test("segments count as hidden if any of their faces are", () => {
  const partition = { faceAtom: Uint32Array.of(0, 1, 2, 3), atomSegment };
  assert.equal(countHidden(Uint8Array.of(1, 0, 0, 1), partition), 2);
  assert.equal(countHidden(null, partition), 0);
});
