import assert from "node:assert/strict";
import { test } from "node:test";
import { dot, frame, subtract } from "../../src/scene/camera.js";
import { dolly, goTo, lookAround, lookTo, standing, standingPlace, walked } from "../../src/scene/walk.js";

/** @typedef {import("../../src/scene/camera.js").Vec3} Vec3 */

const eye = /** @type {Vec3} */ ([1, 2, 1.6]);
const camera = standing(eye, 0.3, 3);

/** @param {number[]} actual @param {number[]} expected */
function near(actual, expected) {
  actual.forEach((value, i) => {
    assert.ok(Math.abs(value - expected[i]) < 1e-9, `${actual} is not ${expected}`);
  });
}

test("turning the head leaves the eye in its place", () => {
  near(frame(camera).eye, eye);
  near(frame(lookAround(camera, 0.5, 0.2)).eye, eye);
  const turned = lookTo(camera, [4, -2, 0]);
  near(frame(turned).eye, eye);
  const way = subtract([4, -2, 0], eye);
  assert.ok(dot(frame(turned).forward, way) / Math.hypot(...way) > 1 - 1e-9);
});

test("walking stays level and goes where one looks; sideways is across", () => {
  const ahead = subtract(frame(walked(camera, ["forward"], 1, 1)).eye, eye);
  assert.ok(Math.abs(ahead[2]) < 1e-9);
  assert.ok(Math.abs(Math.hypot(...ahead) - 1.5) < 1e-9);
  assert.ok(dot(ahead, frame(camera).forward) > 0);
  const left = subtract(frame(walked(camera, ["left"], 1, 1)).eye, eye);
  assert.ok(Math.abs(dot(left, ahead)) < 1e-9);
  assert.ok(dot(left, frame(camera).right) < 0);
  near(frame(walked(camera, ["up", "down"], 1, 1)).eye, eye);
});

test("one goes to just before a point, at one's own height, and on along the view", () => {
  const there = frame(goTo(camera, [5, 2, 0], 0.5)).eye;
  near(there, [4.5, 2, 1.6]);
  const on = subtract(frame(dolly(camera, 2)).eye, eye);
  assert.ok(Math.abs(dot(on, frame(camera).forward) - 2) < 1e-9);
});

test("one stands at eye height over the floor, away from what is near", () => {
  /** @type {number[]} */
  const points = [];
  /** @type {number[]} */
  const normals = [];
  const add = (/** @type {Vec3} */ p, /** @type {Vec3} */ n) => {
    points.push(...p, ...p, ...p);
    normals.push(...n);
  };
  for (let x = 0.1; x < 4; x += 0.1) for (let y = 0.1; y < 4; y += 0.1) add([x, y, 0], [0, 0, 1]);
  for (let x = 0.05; x < 1.5; x += 0.1) for (let y = 0.05; y < 4; y += 0.1) add([x, y, 1.5], [0, 0, 1]);
  const extent = {
    axes: /** @type {[Vec3, Vec3, Vec3]} */ ([
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ]),
  };
  const box = { ...extent, low: /** @type {Vec3} */ ([0, 0, 0]), high: /** @type {Vec3} */ ([4, 4, 2.5]) };
  const place = standingPlace(box, {
    points: Float32Array.from(points),
    normals: Float32Array.from(normals),
  });
  assert.ok(Math.abs(place[2] - 1.6) < 0.1);
  assert.ok(place[0] > 2 && place[0] < 3.6, String(place));
});
