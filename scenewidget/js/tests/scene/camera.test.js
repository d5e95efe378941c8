import assert from "node:assert/strict";
import { test } from "node:test";
import {
  add,
  dot,
  facing,
  firstDirection,
  fit,
  frame,
  fromAbove,
  mainAxis,
  meet,
  orbit,
  pan,
  project as placeOf,
  projectionView,
  ray,
  subtract,
  zoom,
} from "../../src/scene/camera.js";

/** @typedef {import("../../src/scene/camera.js").Vec3} Vec3 */

/** @type {import("../../src/scene/camera.js").Camera} */
const camera = { target: [1, 2, 0.5], yaw: 0.7, pitch: 0.6, distance: 5 };
const bounds = { middle: /** @type {Vec3} */ ([1, 2, 0]), radius: 3 };

/** Where a point appears, -1 to 1 to the right and upwards. @param {typeof camera} from @param {Vec3} point @param {number} aspect */
function project(from, [x, y, z], aspect) {
  const { matrix: m } = projectionView(from, aspect, bounds);
  const row = (/** @type {number} */ i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i];
  return [row(0) / row(3), row(1) / row(3), row(2) / row(3)];
}

/** @param {number[]} actual @param {number[]} expected @param {number} [tolerance] */
function near(actual, expected, tolerance = 1e-9) {
  actual.forEach((value, i) => {
    assert.ok(Math.abs(value - expected[i]) < tolerance, `${actual} is not ${expected}`);
  });
}

/** @param {number} n */
function cube(n) {
  const points = [];
  for (let i = 0; i < 8; i++) points.push(i & 1 ? n : -n, i & 2 ? n : -n, i & 4 ? n : -n);
  return new Float32Array(points);
}

test("the axes are orthonormal, straight from above, too", () => {
  for (const pitch of [-Math.PI / 2, -0.3, 0, 1, Math.PI / 2]) {
    const { right, up, forward } = frame({ ...camera, pitch });
    near([dot(right, right), dot(up, up), dot(forward, forward)], [1, 1, 1]);
    near([dot(right, up), dot(up, forward), dot(forward, right)], [0, 0, 0]);
  }
});

test("the target is in the middle of the picture", () => {
  near(project(camera, camera.target, 1.5).slice(0, 2), [0, 0]);
});

test("a ray through a place meets what is drawn there", () => {
  /** @type {Vec3} */
  const point = [1.4, 1.7, -0.2];
  const [x, y] = project(camera, point, 1.5);
  const direction = ray(camera, x, y, 1.5);
  const { eye } = frame(camera);
  const away = subtract(point, eye);
  const along = dot(away, direction) / dot(direction, direction);
  near(add(eye, direction, along), point);
  const hit = meet(eye, direction, [point, add(point, [1, 0, 0]), add(point, [0, 1, 0])]);
  near(hit ?? [], point);
  assert.equal(
    meet(
      [0, 0, 1],
      [1, 0, 0],
      [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
      ],
    ),
    null,
  );
});

test("all that may be drawn lies between near and far", () => {
  for (const z of [-3, 0, 3]) {
    const depth = project(camera, [1, 2, z], 1)[2];
    assert.ok(depth >= -1 && depth <= 1, `${depth}`);
  }
});

test("orbiting keeps the target and the distance, and stops at the poles", () => {
  const turned = orbit(camera, 1, 10);
  near(turned.target, camera.target);
  near([turned.distance, turned.pitch], [camera.distance, Math.PI / 2]);
});

test("panning moves the picture by as much as the pointer", () => {
  const moved = pan(camera, 0.25, -0.1); // heights of the picture; the picture is 2 high here
  near(project(moved, camera.target, 1).slice(0, 2), [0.5, 0.2]);
});

test("zooming leaves the point under the pointer where it is", () => {
  /** @type {Vec3} */
  const point = [0.2, 2.5, 0.1];
  near(project(zoom(camera, 0.5, point, 0.01), point, 1).slice(0, 2), project(camera, point, 1).slice(0, 2));
  assert.equal(zoom(camera, 1e-9, point, 0.25).distance, 0.25);
});

test("a fitted picture has every point inside and touches two opposite borders", () => {
  for (const [yaw, pitch, aspect] of [
    [0.3, 0.7, 1.5],
    [2, Math.PI / 2, 0.6],
    [-1, -0.4, 3],
  ]) {
    const points = cube(1.5);
    const fitted = fit({ ...camera, yaw, pitch }, points, aspect, 0.1);
    /** @type {number[][]} */
    const seen = [];
    for (let i = 0; i < points.length; i += 3) {
      seen.push(project(fitted, [points[i], points[i + 1], points[i + 2]], aspect));
    }
    for (const axis of [0, 1]) assert.ok(seen.every((place) => Math.abs(place[axis]) < 0.9 + 1e-6));
    const reach = [0, 1].map((axis) => [
      Math.max(...seen.map((place) => place[axis])),
      Math.max(...seen.map((place) => -place[axis])),
    ]);
    assert.ok(reach.some(([one, other]) => Math.abs(one - 0.9) < 1e-6 && Math.abs(other - 0.9) < 1e-6));
  }
});

test("nothing to fit changes nothing", () => {
  assert.equal(fit(camera, new Float32Array(0), 1), camera);
});

test("walls turned by an angle give that angle, modulo a right angle", () => {
  for (const angle of [0.2, -0.5, 0.7]) {
    const normals = [0, 1, 2, 3].flatMap((k) => [
      Math.cos(angle + (k * Math.PI) / 2),
      Math.sin(angle + (k * Math.PI) / 2),
      0,
    ]);
    near([mainAxis(new Float32Array(normals))], [angle], 1e-6);
  }
});

test("a room is first seen from above, a depth camera's fragment from its camera", () => {
  const room = [0, 0, 5, 0, 0, -5, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0];
  assert.ok(firstDirection(new Float32Array(room)).pitch > 0.5);
  const { up } = frame({ ...camera, ...firstDirection(new Float32Array([0, 0, -1])) });
  assert.ok(up[1] < -0.5); // y points down
});

test("the side with more surface facing us is in front", () => {
  const { forward } = frame({
    ...camera,
    ...firstDirection(new Float32Array([0, 0, 1, 3, 0, 0, 0, 0.5, 0])),
  });
  assert.ok(forward[0] < 0 && forward[0] < forward[1]);
});

test("from above, the walls are parallel to the picture", () => {
  const above = fromAbove({ ...camera, yaw: 0.9 }, 0.2);
  near([above.pitch, Math.sin(2 * (above.yaw - 0.2))], [Math.PI / 2, 0]);
  assert.ok(Math.abs(above.yaw - 0.9) <= Math.PI / 4);
});

test("where a point is seen is where it is drawn; behind the eye, nowhere", () => {
  const point = /** @type {Vec3} */ ([1.3, 1.1, 0.2]);
  near(placeOf(camera, point, 1.5) ?? [], project(camera, point, 1.5).slice(0, 2));
  const { eye, forward } = frame(camera);
  assert.equal(placeOf(camera, add(eye, forward, -1), 1.5), null);
});

test("a camera turns to the front of a surface only if it shows its back, and aslant", () => {
  const forward = (/** @type {import("../../src/scene/camera.js").Camera} */ { yaw, pitch }) =>
    frame({ ...camera, yaw, pitch }).forward;
  const above = { ...camera, yaw: 0.3, pitch: 0.7 };
  assert.equal(facing(above, [0, 0, 2]), above);
  for (const normal of /** @type {Array<[number, number, number]>} */ ([
    [-1, 0, 0],
    [0, 3, 0],
    [-1, -1, 0.1],
    [0, 0, -5],
    [-0.2, 0.1, -1],
  ])) {
    const turned = facing(above, normal);
    assert.ok(dot(forward(turned), normal) < -0.25 * Math.hypot(...normal));
    near([turned.distance, ...turned.target], [above.distance, ...above.target], 1e-12);
  }
});
