/**
 * Standing in a room and walking through it.
 *
 * The camera is the orbiting one, with a wider field of view and turned around its eye instead of its target.
 */

import { add, dot, frame, subtract } from "./camera.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {"forward" | "back" | "left" | "right" | "up" | "down" | "turn_left" | "turn_right"} Way */
/** @typedef {import("./section.js").Sample} Sample */
/** @typedef {import("./section.js").Box} Box */

const EYE_HEIGHT = 1.6; // metres above the floor
const ROOM_HEIGHTS = [1.8, 8]; // of scans that are rooms in metres
const TANGENT = Math.tan((66 * Math.PI) / 360);
const GRID = 20;
const STEEPEST = 0.49 * Math.PI;
const SPEED = 1.5; // metres a second
const TURN_SPEED = 1.4; // radians a second

/**
 * Where to stand: at eye height above the floor, where nothing is near, and over something to stand on.
 * @param {Box} extent
 * @param {Sample} sample
 * @returns {Vec3}
 */
export function standingPlace({ axes, low, high }, { points, normals }) {
  const height = high[2] - low[2];
  const isRoom = height > ROOM_HEIGHTS[0] && height < ROOM_HEIGHTS[1];
  const eye = floorOf({ low, high }, { points, normals }) + (isRoom ? EYE_HEIGHT : 0.6 * height);
  const near = 0.2 * height;
  /** @type {Array<[number, number]>} */
  const around = [];
  const isGround = new Uint8Array(GRID * GRID);
  for (let i = 0; i < points.length; i += 9) {
    const [x, y] = axes.map((axis) => dot(axis, [points[i], points[i + 1], points[i + 2]]));
    const z = points[i + 2];
    if (Math.abs(z - eye) < near) around.push([x, y]);
    const column = Math.floor((GRID * (x - low[0])) / (high[0] - low[0] || 1));
    const row = Math.floor((GRID * (y - low[1])) / (high[1] - low[1] || 1));
    const isInside = column >= 0 && column < GRID && row >= 0 && row < GRID;
    if (isInside && z < eye - near && normals[i / 3 + 2] > 0) isGround[row * GRID + column] = 1;
  }
  const step = Math.max(1, Math.floor(around.length / 3000));
  let best = { x: (low[0] + high[0]) / 2, y: (low[1] + high[1]) / 2, free: -1 };
  for (let cell = 0; cell < GRID * GRID; cell++) {
    if (!isGround[cell]) continue;
    const x = low[0] + (((cell % GRID) + 0.5) / GRID) * (high[0] - low[0]);
    const y = low[1] + ((Math.floor(cell / GRID) + 0.5) / GRID) * (high[1] - low[1]);
    let free = Math.min(x - low[0], high[0] - x, y - low[1], high[1] - y);
    for (let i = 0; i < around.length && free > best.free; i += step)
      free = Math.min(free, Math.hypot(around[i][0] - x, around[i][1] - y));
    if (free > best.free) best = { x, y, free };
  }
  const flat = add([axes[0][0] * best.x, axes[0][1] * best.x, 0], axes[1], best.y);
  return [flat[0], flat[1], eye];
}

/**
 * Height of the floor: where in the lower half most surface faces up.
 * @param {{ low: Vec3, high: Vec3 }} extent
 * @param {Sample} sample
 */
function floorOf({ low, high }, { points, normals }) {
  const bins = new Float64Array(50);
  for (let i = 0; i < normals.length; i += 3) {
    const t = (points[3 * i + 2] - low[2]) / (high[2] - low[2] || 1);
    if (normals[i + 2] > 0 && t >= 0 && t < 0.5) bins[Math.floor(100 * t)] += normals[i + 2];
  }
  const most = bins.indexOf(Math.max(...bins));
  return low[2] + ((most + 0.5) / 100) * (high[2] - low[2]);
}

/**
 * A camera at a place.
 * @param {Vec3} eye
 * @param {number} yaw  as of the orbiting camera: of the way from what is seen to the eye
 * @param {number} reach  distance at which movements of the pointer are exact
 * @returns {Camera}
 */
export function standing(eye, yaw, reach) {
  return withEye({ target: eye, yaw, pitch: 0.06, distance: reach, tangent: TANGENT }, eye);
}

/**
 * Turn the head.
 * @param {Camera} camera
 * @param {number} turn  to the left
 * @param {number} rise  upwards
 * @returns {Camera}
 */
export function lookAround(camera, turn, rise) {
  const pitch = Math.min(STEEPEST, Math.max(-STEEPEST, camera.pitch - rise));
  return withEye({ ...camera, yaw: camera.yaw + turn, pitch }, frame(camera).eye);
}

/**
 * Turn towards a point.
 * @param {Camera} camera
 * @param {Vec3} point
 */
export function lookTo(camera, point) {
  const { eye } = frame(camera);
  const [x, y, z] = subtract(eye, point);
  const pitch = Math.min(STEEPEST, Math.max(-STEEPEST, Math.atan2(z, Math.hypot(x, y))));
  return withEye({ ...camera, yaw: Math.atan2(y, x), pitch }, eye);
}

/**
 * Go to just before a point, at the height where the eye is.
 * @param {Camera} camera
 * @param {Vec3} point
 * @param {number} gap
 */
export function goTo(camera, point, gap) {
  const { eye } = frame(camera);
  const [x, y] = subtract(point, eye);
  const away = Math.hypot(x, y);
  const t = Math.max(0, away - gap) / (away || 1);
  return withEye(camera, add(eye, [x, y, 0], t));
}

/**
 * Go or turn for some time.
 * @param {Camera} camera
 * @param {Iterable<Way>} ways
 * @param {number} seconds
 * @param {number} scale  1 in a room in metres
 */
export function walked(camera, ways, seconds, scale) {
  const ahead = [-Math.cos(camera.yaw), -Math.sin(camera.yaw)];
  const far = SPEED * scale * seconds;
  let next = camera;
  for (const way of ways) {
    const { eye } = frame(next);
    /** @type {Record<Way, Vec3>} */
    const steps = {
      forward: [ahead[0], ahead[1], 0],
      back: [-ahead[0], -ahead[1], 0],
      left: [-ahead[1], ahead[0], 0],
      right: [ahead[1], -ahead[0], 0],
      up: [0, 0, 1],
      down: [0, 0, -1],
      turn_left: [0, 0, 0],
      turn_right: [0, 0, 0],
    };
    if (way === "turn_left") next = lookAround(next, TURN_SPEED * seconds, 0);
    else if (way === "turn_right") next = lookAround(next, -TURN_SPEED * seconds, 0);
    else next = withEye(next, add(eye, steps[way], far));
  }
  return next;
}

/**
 * Go on along the view.
 * @param {Camera} camera
 * @param {number} distance
 */
export function dolly(camera, distance) {
  const { eye, forward } = frame(camera);
  return withEye(camera, add(eye, forward, distance));
}

/** @param {Camera} camera @param {Vec3} eye @returns {Camera} */
function withEye(camera, eye) {
  return { ...camera, target: add(eye, frame(camera).forward, camera.distance) };
}
