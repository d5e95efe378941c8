import assert from "node:assert/strict";
import { test } from "node:test";
import { createSight } from "../../src/scene/sight.js";

// a picture from above: all of it shows face 0, a large triangle at the height 1
const bytes = Uint8Array.from({ length: 4 * 64 }, (_, i) => Number(i % 4 === 0));
const camera = {
  target: /** @type {[number, number, number]} */ ([0, 0, 0]),
  ...{ yaw: 0, pitch: Math.PI / 2, distance: 5, tangent: 0.5 },
};
const snapshot = { numbers: { width: 8, height: 8, bytes }, camera, aspect: 1 };
const vertices = Float32Array.of(
  ...[-9, -9, 1, 9, -9, 1, 0, 9, 1],
  ...[0, 0, 1, 0.1, 0, 1, 0, 0.1, 1],
  ...[0, 0, -6, 0.1, 0, -6, 0, 0.1, -6],
  ...[99, 0, 1, 99.1, 0, 1, 99, 0.1, 1],
);
const faces = Uint32Array.of(0, 1, 2, 3, 4, 5, 6, 7, 8, 4, 3, 5, 9, 10, 11);
const sight = createSight(snapshot, { width: 100, height: 100 }, { vertices, faces });

test("a face without a pixel is seen in the plane of what its pixel shows, from the same side", () => {
  assert.deepEqual([1, 2, 3, 4].map(sight.isSeen), [true, false, false, false]);
});

test("places, distances and the width of a pixel are those of the picture", () => {
  const { x, y } = sight.placeOf(1);
  // yaw 0, from above: x of the scan goes down the picture's left, y to the right
  assert.ok(Math.abs(x - (50 + (100 * (0.1 / 3)) / 4)) < 1e-4, String(x));
  assert.ok(Math.abs(Math.abs(y - 50) - (100 * (0.1 / 3)) / 4) < 1e-4, String(y));
  assert.ok(Math.abs(sight.pixelAt([0, 0, 1]) - 0.04) < 1e-9);
  assert.ok(Math.abs(sight.awayFrom(1, [0.1 / 3, 0.1 / 3, 3]) - 4) < 1e-5);
});
