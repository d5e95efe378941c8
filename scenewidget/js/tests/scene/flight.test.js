import assert from "node:assert/strict";
import { test } from "node:test";
import { between, shorterTurn } from "../../src/scene/flight.js";

/** @type {import("../../src/scene/camera.js").Camera} */
const from = { target: [0, 0, 0], yaw: 0.1, pitch: 0.5, distance: 1 };
/** @type {import("../../src/scene/camera.js").Camera} */
const to = { target: [2, 0, 0], yaw: 6.2, pitch: 0.7, distance: 4 };

test("one turns the short way", () => {
  const { yaw } = shorterTurn(from, to);
  assert.ok(Math.abs(yaw - from.yaw) < 0.2);
  assert.ok(Math.abs(Math.cos(yaw) - Math.cos(to.yaw)) < 1e-12);
});

test("a flight begins and ends where it should; half the way is half the factor", () => {
  assert.deepEqual(between(from, to, 0).target, from.target);
  const end = between(from, to, 1);
  assert.ok(Math.abs(end.distance - 4) < 1e-12 && Math.abs(end.target[0] - 2) < 1e-12);
  const half = between(from, to, 0.5);
  assert.ok(Math.abs(half.distance - 2) < 1e-12 && Math.abs(half.target[0] - 1) < 1e-12);
});
