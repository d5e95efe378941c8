import assert from "node:assert/strict";
import { test } from "node:test";
import { axisNames, upright, uprightAxes } from "../../src/scene/upright.js";

/** @typedef {import("../../src/scene/camera.js").Vec3} Vec3 */

test("the axes are a right-handed frame whose last one is up", () => {
  for (const up of /** @type {Vec3[]} */ ([
    [0, 0, 1],
    [0, -1, 0],
    [0.6, 0, 0.8],
  ])) {
    const [a, b, c] = uprightAxes(up);
    const cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    cross.forEach((value, k) => {
      assert.ok(Math.abs(value - c[k]) < 1e-12);
    });
    assert.deepEqual(c, up);
  }
});

test("points are turned so that up is z, and left alone if it is", () => {
  const points = Float32Array.of(1, 2, 3);
  assert.equal(upright(points, [0, 0, 1]), points);
  const turned = upright(points, [0, 1, 0]);
  assert.equal(turned[2], 2);
  assert.ok(Math.abs(Math.hypot(...turned) - Math.hypot(1, 2, 3)) < 1e-6);
});

test("axes along the mesh's own have their names", () => {
  assert.deepEqual(axisNames([0, 0, 1]), ["+x", "+y"]);
  assert.deepEqual(axisNames([0.6, 0, 0.8]).includes(""), true);
});
