import assert from "node:assert/strict";
import { test } from "node:test";
import { faceIn, pointIn } from "../../src/scene/snapshot.js";

// two by two pixels, as WebGL gives them, the lowest row first: background and face 0, then face 258 twice
const bytes = Uint8Array.of(0, 0, 0, 9, 1, 0, 0, 9, 3, 1, 0, 9, 3, 1, 0, 9);
const camera = {
  target: /** @type {[number, number, number]} */ ([0, 0, 0]),
  yaw: 0,
  pitch: Math.PI / 2,
  distance: 5,
};
const snapshot = { numbers: { width: 2, height: 2, bytes }, camera, aspect: 1 };
const size = { width: 100, height: 100 };

test("places are looked up from the upper left, whatever the resolution", () => {
  const at = (/** @type {number} */ x, /** @type {number} */ y) => faceIn(snapshot, { x, y }, size);
  assert.deepEqual([at(10, 10), at(90, 10), at(10, 90), at(90, 90)], [258, 258, null, 0]);
});

test("outside the picture there is nothing", () => {
  for (const place of [
    { x: -1, y: 5 },
    { x: 100, y: 5 },
    { x: 5, y: 100 },
    { x: Number.NaN, y: 5 },
  ])
    assert.equal(faceIn(snapshot, place, size), null);
});

test("the point lies on the face, where the ray meets it", () => {
  const vertices = Float32Array.of(-9, -9, 1, 9, -9, 1, 0, 9, 1);
  const mesh = { vertices, faces: Uint32Array.of(0, 1, 2) };
  const point = pointIn(snapshot, { x: 75, y: 75 }, size, mesh);
  assert.ok(point && Math.abs(point[2] - 1) < 1e-9);
  assert.equal(pointIn(snapshot, { x: 10, y: 90 }, size, mesh), null);
});
