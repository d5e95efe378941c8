import assert from "node:assert/strict";
import { test } from "node:test";
import { dot, frame } from "../../src/scene/camera.js";
import { sample } from "../../src/scene/geometry.js";
import { belowCeiling, boxOf, extentOf, isWhole, pointsInside, WHOLE } from "../../src/scene/section.js";
import { axisNames, upright, uprightAxes } from "../../src/scene/upright.js";
import { dolly, goTo, lookAround, lookTo, standing, standingPlace, walked } from "../../src/scene/walk.js";

/** @typedef {import("../../src/scene/camera.js").Vec3} Vec3 */
/** @typedef {import("../../src/scene/section.js").Range} Range */

/** A room of 4 × 3 × 2.5 m, seen from inside, turned about the vertical. @param {number} angle @param {boolean} [hasCeiling] */
function room(angle, hasCeiling = true) {
  const n = 24;
  const vertices = [];
  const faces = [];
  /** @type {Array<[Vec3, Vec3, Vec3]>} */
  const sides = [
    [
      [0, 0, 0],
      [4, 0, 0],
      [0, 3, 0],
    ],
    [
      [0, 0, 0],
      [0, 3, 0],
      [0, 0, 2.5],
    ],
    [
      [4, 0, 0],
      [0, 0, 2.5],
      [0, 3, 0],
    ],
    [
      [0, 0, 0],
      [0, 0, 2.5],
      [4, 0, 0],
    ],
    [
      [0, 3, 0],
      [4, 0, 0],
      [0, 0, 2.5],
    ],
  ];
  if (hasCeiling)
    sides.push([
      [0, 0, 2.5],
      [0, 3, 0],
      [4, 0, 0],
    ]);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  for (const [o, a, b] of sides) {
    const first = vertices.length / 3;
    for (let i = 0; i <= n; i++)
      for (let j = 0; j <= n; j++) {
        const [x, y, z] = o.map((value, k) => value + (i / n) * a[k] + (j / n) * b[k]);
        vertices.push(c * x - s * y, s * x + c * y, z);
      }
    for (let i = 0; i < n; i++)
      for (let j = 0; j < n; j++) {
        const v = first + i * (n + 1) + j;
        faces.push(v, v + n + 1, v + n + 2, v, v + n + 2, v + 1);
      }
  }
  return sample({ vertices: new Float32Array(vertices), faces: new Uint32Array(faces) });
}

test("the extent follows the walls", () => {
  const extent = extentOf(room(0.4));
  const lengths = extent.low.map((low, k) => extent.high[k] - low).sort((a, b) => a - b);
  for (const [k, expected] of [2.5, 3, 4].entries()) assert.ok(Math.abs(lengths[k] - expected) < 0.02);
});

test("an end at the end cuts nothing, one inside cuts there", () => {
  const { points, normals } = room(0);
  const extent = extentOf({ points, normals });
  assert.equal(boxOf(extent, WHOLE), null);
  assert.ok(isWhole(WHOLE));
  /** @type {Range[]} */
  const ranges = [
    [0, 1],
    [0, 1],
    [0.2, 1],
  ];
  const box = boxOf(extent, ranges);
  assert.ok(box && !isWhole(ranges));
  assert.ok(box.high[2] > 1e6);
  const kept = pointsInside(points, box);
  assert.ok(kept.length > 0 && kept.length < points.length);
  for (let i = 0; i < kept.length; i += 9) assert.ok(kept[i + 2] >= 0.5 - 1e-6);
});

test("the ceiling is cut just below where it is", () => {
  const closed = room(0.3);
  const high = belowCeiling(extentOf(closed), closed);
  assert.ok(high > 0.88 && high < 0.97, String(high));
  const open = room(0.3, false);
  assert.equal(belowCeiling(extentOf(open), open), 0.8);
});

test("one stands at eye height in the middle of an empty room", () => {
  const mesh = room(0);
  const [x, y, z] = standingPlace(extentOf(mesh), mesh);
  assert.ok(Math.abs(z - 1.6) < 0.05);
  assert.ok(Math.abs(y - 1.5) < 0.3 && x > 1.2 && x < 2.8);
});

test("turning keeps the eye, walking keeps its height", () => {
  const camera = standing([1, 2, 1.6], 0.5, 1.5);
  const near = (/** @type {Vec3} */ a, /** @type {number[]} */ b) =>
    a.forEach((value, k) => {
      assert.ok(Math.abs(value - b[k]) < 1e-9, `${a} is not ${b}`);
    });
  near(frame(camera).eye, [1, 2, 1.6]);
  const turned = lookAround(camera, 0.7, -0.3);
  near(frame(turned).eye, [1, 2, 1.6]);
  assert.ok(dot(frame(turned).forward, [0, 0, 1]) < dot(frame(camera).forward, [0, 0, 1]));
  const ahead = frame(walked(turned, ["forward"], 1, 1)).eye;
  assert.ok(Math.abs(Math.hypot(ahead[0] - 1, ahead[1] - 2) - 1.5) < 1e-9);
  assert.ok(Math.abs(ahead[2] - 1.6) < 1e-9);
  near(frame(walked(turned, ["left", "right", "forward", "back", "up", "down"], 1, 1)).eye, [1, 2, 1.6]);
  assert.ok(dot([ahead[0] - 1, ahead[1] - 2, 0], frame(turned).forward) > 0);
  const left = frame(walked(turned, ["left"], 1, 1)).eye;
  assert.ok(dot([left[0] - 1, left[1] - 2, 0], frame(turned).right) < 0);
  near(
    frame(dolly(camera, 2)).eye,
    [0, 1, 2].map((k) => [1, 2, 1.6][k] + 2 * frame(camera).forward[k]),
  );
});

test("one looks at a point, and goes to just before it", () => {
  const camera = standing([1, 2, 1.6], 0.5, 1.5);
  const { eye, forward } = frame(lookTo(camera, [4, 6, 0]));
  const away = [3, 4, -1.6];
  assert.ok(Math.abs(dot(forward, /** @type {Vec3} */ (away)) - Math.hypot(...away)) < 1e-9);
  assert.deepEqual(
    eye.map((x) => Math.round(1000 * x) / 1000),
    [1, 2, 1.6],
  );
  const there = frame(goTo(camera, [4, 6, 0], 1)).eye;
  assert.deepEqual(
    there.map((x) => Math.round(1000 * x) / 1000),
    [3.4, 5.2, 1.6],
  );
});

test("whatever is up comes to lie along z, without mirroring", () => {
  const directions = /** @type {Vec3[]} */ ([
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [-1, 0, 0],
    [0, -1, 0],
    [0, 0, -1],
    [0.6, 0, 0.8],
    [0.48, -0.6, 0.64],
  ]);
  for (const up of directions) {
    const [x, y, z] = uprightAxes(up);
    for (const [a, b] of [
      [x, y],
      [y, z],
      [z, x],
    ])
      assert.ok(Math.abs(dot(a, b)) < 1e-9);
    const volume =
      x[0] * (y[1] * z[2] - y[2] * z[1]) -
      x[1] * (y[0] * z[2] - y[2] * z[0]) +
      x[2] * (y[0] * z[1] - y[1] * z[0]);
    assert.ok(Math.abs(volume - 1) < 1e-9);
    const [tip] = [upright(new Float32Array(up), up)];
    assert.ok(Math.abs(tip[2] - 1) < 1e-6);
  }
  const points = new Float32Array([1, 2, 3]);
  assert.equal(upright(points, [0, 0, 1]), points);
  assert.deepEqual(axisNames([0, 0, 1]), ["+x", "+y"]);
  assert.deepEqual(axisNames([0, 1, 0]), ["+z", "+x"]);
});
