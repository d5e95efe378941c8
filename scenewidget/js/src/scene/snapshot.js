/** The picture as it was when it last stood still: which face lay where, and where the eye was. */

import { frame, meet, ray } from "./camera.js";
import { cornersOf } from "./geometry.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Place} Place */
/** @typedef {import("./camera.js").Vec3} Vec3 */

/**
 * @typedef {object} Snapshot
 * @property {import("./renderer.js").Numbers} numbers
 * @property {Camera} camera
 * @property {number} aspect
 */

/** @typedef {{ width: number, height: number }} Size  of the picture, in CSS pixels */

/**
 * Face at a place; null on the background and outside.
 * @param {Snapshot} snapshot
 * @param {Place} place
 * @param {Size} size
 */
export function faceIn({ numbers: { width, height, bytes } }, { x, y }, size) {
  const column = Math.floor((x / size.width) * width);
  const row = height - 1 - Math.floor((y / size.height) * height);
  if (!(column >= 0 && column < width && row >= 0 && row < height)) return null;
  const i = 4 * (row * width + column);
  const number = bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16);
  return number === 0 ? null : number - 1;
}

/**
 * Faces within so many pixels of a place, as far as they are seen.
 * @param {Snapshot} snapshot
 * @param {Place} place
 * @param {number} radius  CSS pixels
 * @param {Size} size
 * @returns {Set<number>}
 */
export function facesAround({ numbers: { width, height, bytes } }, { x, y }, radius, size) {
  const [toX, toY] = [width / size.width, height / size.height];
  const [middleX, middleY] = [x * toX, height - y * toY];
  /** @type {Set<number>} */
  const faces = new Set();
  const first = Math.max(0, Math.floor(middleY - radius * toY));
  const last = Math.min(height - 1, Math.floor(middleY + radius * toY));
  for (let row = first; row <= last; row++) {
    const up = (row + 0.5 - middleY) / (radius * toY);
    const half = radius * toX * Math.sqrt(Math.max(0, 1 - up * up));
    const end = Math.min(width - 1, Math.floor(middleX + half));
    for (let column = Math.max(0, Math.floor(middleX - half)); column <= end; column++) {
      const i = 4 * (row * width + column);
      const number = bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16);
      if (number > 0) faces.add(number - 1);
    }
  }
  return faces;
}

/**
 * Point of the surface at a place; null on the background and outside.
 * @param {Snapshot} snapshot
 * @param {Place} place
 * @param {Size} size
 * @param {import("./geometry.js").Surface} mesh
 * @returns {Vec3 | null}
 */
export function pointIn(snapshot, place, size, mesh) {
  const face = faceIn(snapshot, place, size);
  if (face === null) return null;
  const corners = cornersOf(mesh, face);
  const corner = (/** @type {number} */ k) => /** @type {Vec3} */ (corners.slice(3 * k, 3 * k + 3));
  const { camera, aspect } = snapshot;
  const direction = rayAt(camera, place, size, aspect);
  return meet(frame(camera).eye, direction, [corner(0), corner(1), corner(2)]);
}

/**
 * Direction in which a place of the picture is seen.
 * @param {Camera} camera
 * @param {Place} place
 * @param {Size} size
 * @param {number} aspect
 */
export function rayAt(camera, { x, y }, size, aspect) {
  return ray(camera, (2 * x) / size.width - 1, 1 - (2 * y) / size.height, aspect);
}
