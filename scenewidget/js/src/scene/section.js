/**
 * A box that cuts the scan open: along the walls, across them, and upwards.
 *
 * Its ranges are parts of the scan's extent, 0 to 1; an end at 0 or 1 cuts nothing, not even what sticks out.
 */

import { mainAxis } from "./camera.js";

/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {[number, number]} Range */
/** @typedef {{ axes: [Vec3, Vec3, Vec3], low: Vec3, high: Vec3 }} Box */
/** @typedef {{ points: Float32Array, normals: Float32Array }} Sample */

/** Nothing is cut. @type {Range[]} */
export const WHOLE = [
  [0, 1],
  [0, 1],
  [0, 1],
];
const STRAY = 0.002; // part of the points that may stick out of the extent
const FAR = 1e9;
const HEIGHTS = 100;
const BELOW_CEILING = 0.06; // of the height, that goes with the ceiling
const USUAL_CUT = 0.8;

/** @param {Range[]} ranges */
export function isWhole(ranges) {
  return ranges.every(([low, high]) => low <= 0 && high >= 1);
}

/**
 * The scan's extent along its walls and upwards.
 * @param {Sample} sample
 * @returns {Box}
 */
export function extentOf({ points, normals }) {
  const angle = mainAxis(normals);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  /** @type {[Vec3, Vec3, Vec3]} */
  const axes = [
    [c, s, 0],
    [-s, c, 0],
    [0, 0, 1],
  ];
  const ends = axes.map(([x, y, z]) => {
    const along = new Float32Array(points.length / 3);
    for (let i = 0; i < along.length; i++)
      along[i] = x * points[3 * i] + y * points[3 * i + 1] + z * points[3 * i + 2];
    along.sort();
    const stray = Math.floor(STRAY * along.length);
    return [along[stray] ?? 0, along[along.length - 1 - stray] ?? 0];
  });
  return {
    axes,
    low: [ends[0][0], ends[1][0], ends[2][0]],
    high: [ends[0][1], ends[1][1], ends[2][1]],
  };
}

/**
 * The box to keep; null if that is all.
 * @param {Box} extent
 * @param {Range[]} ranges
 * @returns {Box | null}
 */
export function boxOf({ axes, low, high }, ranges) {
  if (isWhole(ranges)) return null;
  const at = (/** @type {number} */ k, /** @type {number} */ t) => low[k] + t * (high[k] - low[k]);
  const lows = ranges.map(([from], k) => (from <= 0 ? -FAR : at(k, from)));
  const highs = ranges.map(([, to], k) => (to >= 1 ? FAR : at(k, to)));
  return { axes, low: [lows[0], lows[1], lows[2]], high: [highs[0], highs[1], highs[2]] };
}

/**
 * The points of a triangle soup whose triangles begin in a box.
 * @param {Float32Array} points  nine numbers a triangle
 * @param {Box} box
 */
export function pointsInside(points, { axes, low, high }) {
  const kept = new Float32Array(points.length);
  let n = 0;
  for (let i = 0; i < points.length; i += 9) {
    const isInside = axes.every(([x, y, z], k) => {
      const along = x * points[i] + y * points[i + 1] + z * points[i + 2];
      return along >= low[k] && along <= high[k];
    });
    if (!isInside) continue;
    kept.set(points.subarray(i, i + 9), n);
    n += 9;
  }
  return kept.subarray(0, n);
}

/**
 * How far up to keep a room so that its ceiling goes: just below the height in its upper half at which most
 * surface faces down, or four fifths if none does.
 * @param {Box} extent
 * @param {Sample} sample
 */
export function belowCeiling({ low, high }, { points, normals }) {
  const down = new Float64Array(HEIGHTS);
  let up = 0;
  for (let i = 0; i < normals.length; i += 3) {
    const z = normals[i + 2];
    const isLevel = Math.abs(z) > 0.8 * Math.hypot(normals[i], normals[i + 1], z);
    if (!isLevel) continue;
    if (z > 0) up += z;
    const height = (points[3 * i + 2] - low[2]) / (high[2] - low[2] || 1);
    if (z < 0 && height > 0.5) down[Math.min(HEIGHTS - 1, Math.floor(HEIGHTS * height))] -= z;
  }
  let [best, most] = [-1, 0];
  for (let i = HEIGHTS / 2; i < HEIGHTS; i++) {
    const area = down[i] + (down[i - 1] ?? 0) + (down[i + 1] ?? 0);
    if (area > most) [best, most] = [i, area];
  }
  if (most < 0.1 * up || best < 0) return USUAL_CUT;
  return Math.max(0.3, (best - 1) / HEIGHTS - BELOW_CEILING);
}

/**
 * Whether the middle of a face lies in a box.
 * @param {{ vertices: Float32Array, faces: Uint32Array }} mesh
 * @param {number} face
 * @param {Box} box
 */
export function isInside({ vertices, faces }, face, { axes, low, high }) {
  for (let k = 0; k < 3; k++) {
    let along = 0;
    for (let i = 3 * face; i < 3 * face + 3; i++) {
      const v = 3 * faces[i];
      along += vertices[v] * axes[k][0] + vertices[v + 1] * axes[k][1] + vertices[v + 2] * axes[k][2];
    }
    if (along < 3 * low[k] || along > 3 * high[k]) return false;
  }
  return true;
}
