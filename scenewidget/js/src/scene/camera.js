/**
 * An orbiting camera in a world with z up, as plain numbers.
 *
 * The eye is at `target + distance * direction(yaw, pitch)` and looks at the target. Every function returns
 * a new camera. Angles are radians, lengths those of the mesh (metres).
 */

/** @typedef {[number, number, number]} Vec3 */
/**
 * @typedef {object} Camera
 * @property {Vec3} target
 * @property {number} yaw
 * @property {number} pitch
 * @property {number} distance
 * @property {number} [tangent]  of half the height of the picture as an angle; narrow by default
 */
/** @typedef {{ eye: Vec3, right: Vec3, up: Vec3, forward: Vec3 }} Frame */
/** @typedef {{ x: number, y: number }} Place  in the picture, pixels from the upper left */
/** @typedef {{ middle: Vec3, radius: number }} Ball */

/** Of half the height of the picture as an angle: narrow, so that rooms don't look stretched. */
export const TANGENT = Math.tan((18 * Math.PI) / 180);
const STEEPEST = Math.PI / 2;
const ASLANT = Math.PI / 5; // from where a surface is seen rather than straight on
const FIRST_PITCH = (42 * Math.PI) / 180;

/**
 * Where the eye is and which way it looks; well defined straight from above, too.
 * @param {Camera} camera
 * @returns {Frame}
 */
export function frame({ target, yaw, pitch, distance }) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  /** @type {Vec3} */
  const forward = [-cp * cy, -cp * sy, -sp];
  return {
    eye: add(target, forward, -distance),
    right: [-sy, cy, 0],
    up: [-sp * cy, -sp * sy, cp],
    forward,
  };
}

/**
 * Turn around the target.
 * @param {Camera} camera
 * @param {number} turn  to the left
 * @param {number} rise  upwards
 * @returns {Camera}
 */
export function orbit(camera, turn, rise) {
  const pitch = Math.min(STEEPEST, Math.max(-STEEPEST, camera.pitch + rise));
  return { ...camera, yaw: camera.yaw + turn, pitch };
}

/**
 * Move the picture under the pointer.
 * @param {Camera} camera
 * @param {number} dx  to the right, in heights of the picture
 * @param {number} dy  downwards, in heights of the picture
 * @returns {Camera}
 */
export function pan(camera, dx, dy) {
  const { right, up } = frame(camera);
  const height = 2 * (camera.tangent ?? TANGENT) * camera.distance;
  return { ...camera, target: add(add(camera.target, right, -dx * height), up, dy * height) };
}

/**
 * Come nearer (factor < 1) or go away, leaving one point of the world where it is in the picture.
 * @param {Camera} camera
 * @param {number} factor
 * @param {Vec3} point
 * @param {number} nearest  smallest distance
 * @returns {Camera}
 */
export function zoom(camera, factor, point, nearest) {
  const distance = Math.max(nearest, camera.distance * factor);
  const scale = distance / camera.distance;
  return { ...camera, distance, target: add(point, subtract(camera.target, point), scale) };
}

/**
 * Direction from the eye through a place in the picture, not normalised.
 * @param {Camera} camera
 * @param {number} x  -1 left to 1 right
 * @param {number} y  -1 bottom to 1 top
 * @param {number} aspect
 * @returns {Vec3}
 */
export function ray(camera, x, y, aspect) {
  const { right, up, forward } = frame(camera);
  const { tangent = TANGENT } = camera;
  return add(add(forward, right, x * tangent * aspect), up, y * tangent);
}

/**
 * Projection times view, column by column as WebGL wants it.
 * @param {Camera} camera
 * @param {number} aspect
 * @param {Ball} bounds  all that may be drawn
 * @returns {{ matrix: number[], near: number, far: number }}
 */
export function projectionView(camera, aspect, { middle, radius }) {
  const { eye, right, up, forward } = frame(camera);
  const depth = dot(subtract(middle, eye), forward);
  const near = Math.max(depth - radius, 0.002 * radius, 1e-6);
  const far = Math.max(depth + radius, near * 2);
  const { tangent = TANGENT } = camera;
  const sx = 1 / (tangent * aspect);
  const sy = 1 / tangent;
  const sz = (far + near) / (far - near);
  const tz = (-2 * far * near) / (far - near);
  const [rx, ry, rz] = [-dot(right, eye), -dot(up, eye), -dot(forward, eye)];
  const column = (/** @type {number} */ i) => [sx * right[i], sy * up[i], sz * forward[i], forward[i]];
  return {
    matrix: [...column(0), ...column(1), ...column(2), sx * rx, sy * ry, sz * rz + tz, rz],
    near,
    far,
  };
}

/**
 * Where a point is seen, each from -1 to 1; null behind the eye.
 * @param {Camera} camera
 * @param {Vec3} point
 * @param {number} aspect
 * @returns {[number, number] | null}
 */
export function project(camera, point, aspect) {
  const { eye, right, up, forward } = frame(camera);
  const away = subtract(point, eye);
  const depth = dot(away, forward);
  if (depth <= 0) return null;
  const { tangent = TANGENT } = camera;
  return [dot(away, right) / (depth * tangent * aspect), dot(away, up) / (depth * tangent)];
}

/**
 * The nearest camera of the same direction that has all points in the picture.
 * @param {Camera} camera
 * @param {Float32Array} points  x, y, z one after another
 * @param {number} aspect
 * @param {number} margin  part of the picture left free
 * @returns {Camera}
 */
export function fit(camera, points, aspect, margin = 0.1) {
  const { right, up, forward } = frame(camera);
  const ty = (camera.tangent ?? TANGENT) * (1 - margin);
  const tx = ty * aspect;
  // a point (x, y, z) of the camera's axes is inside if |x - cx| <= (z + d) tx and |y - cy| <= (z + d) ty
  const worst = { left: -Infinity, right: -Infinity, bottom: -Infinity, top: -Infinity };
  for (let i = 0; i < points.length; i += 3) {
    const [px, py, pz] = [points[i], points[i + 1], points[i + 2]];
    const x = px * right[0] + py * right[1] + pz * right[2];
    const y = px * up[0] + py * up[1] + pz * up[2];
    const z = px * forward[0] + py * forward[1] + pz * forward[2];
    worst.right = Math.max(worst.right, x - z * tx);
    worst.left = Math.max(worst.left, -x - z * tx);
    worst.top = Math.max(worst.top, y - z * ty);
    worst.bottom = Math.max(worst.bottom, -y - z * ty);
  }
  if (!Number.isFinite(worst.left)) return camera;
  const away = Math.max((worst.left + worst.right) / (2 * tx), (worst.bottom + worst.top) / (2 * ty));
  const [cx, cy] = [(worst.right - worst.left) / 2, (worst.top - worst.bottom) / 2];
  // the eye lies `away` behind the plane z = 0; keep the target in the middle of the points' depth
  let [near, far] = [Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3) {
    const z = points[i] * forward[0] + points[i + 1] * forward[1] + points[i + 2] * forward[2];
    near = Math.min(near, z);
    far = Math.max(far, z);
  }
  const depth = (near + far) / 2;
  const target = add(add(scaled(right, cx), up, cy), forward, depth);
  return { ...camera, target, distance: Math.max(away + depth, 1e-6) };
}

/**
 * Direction from which to look first: from outside and above, so that removed back faces open the room, across
 * its corners, from the side where most of the surface faces us. What can only be seen from below, such as a
 * fragment in the coordinates of its depth camera (z away from it, y down), is seen as that camera saw it.
 * @param {Float32Array} normals  area-weighted normals of some faces, one after another
 * @returns {{ yaw: number, pitch: number }}
 */
export function firstDirection(normals) {
  const axis = mainAxis(normals);
  const quarter = Math.PI / 2;
  const above = [1, 2, 3, 4].flatMap((side) =>
    [2 / 3, 1 / 3].map((turn) => ({ yaw: axis + (side - turn) * quarter, pitch: FIRST_PITCH })),
  );
  const seen = above.map((direction) => facingArea(normals, direction));
  const most = Math.max(...seen);
  const below = { yaw: -quarter, pitch: -0.85 * quarter };
  if (facingArea(normals, below) > 4 * most) return below;
  return above[seen.findIndex((area) => area >= 0.98 * most)];
}

/**
 * Area of the faces that show their front, as seen in a direction.
 * @param {Float32Array} normals
 * @param {{ yaw: number, pitch: number }} direction
 */
function facingArea(normals, { yaw, pitch }) {
  const [x, y, z] = frame({ target: [0, 0, 0], yaw, pitch, distance: 1 }).eye;
  let area = 0;
  for (let i = 0; i < normals.length; i += 3) {
    area += Math.max(0, normals[i] * x + normals[i + 1] * y + normals[i + 2] * z);
  }
  return area;
}

/**
 * Angle of the walls, modulo a right angle.
 * @param {Float32Array} normals
 */
export function mainAxis(normals) {
  let [c, s] = [0, 0];
  for (let i = 0; i < normals.length; i += 3) {
    const weight = Math.hypot(normals[i], normals[i + 1]);
    const angle = Math.atan2(normals[i + 1], normals[i]);
    c += weight * Math.cos(4 * angle);
    s += weight * Math.sin(4 * angle);
  }
  return Math.atan2(s, c) / 4;
}

/**
 * Straight down, the walls parallel to the picture, with the least turn from where one is.
 * @param {Camera} camera
 * @param {number} axis  of the walls
 * @returns {Camera}
 */
export function fromAbove(camera, axis) {
  const quarter = Math.PI / 2;
  return { ...camera, pitch: STEEPEST, yaw: axis + Math.round((camera.yaw - axis) / quarter) * quarter };
}

/**
 * A camera that sees the front of a surface: turned only if it shows its back or its edge.
 * @param {Camera} camera
 * @param {Vec3} normal  need not be normalised
 * @returns {Camera}
 */
export function facing(camera, normal) {
  const [x, y, z] = normal;
  const length = Math.hypot(x, y, z) || 1;
  if (dot(frame(camera).forward, normal) <= -0.25 * length) return camera;
  const level = Math.hypot(x, y) / length;
  const away = level < 0.4 ? 0 : Math.atan2(y, x) - camera.yaw;
  const turn = Math.atan2(Math.sin(away), Math.cos(away)); // the short way round
  const aslant = Math.sign(turn) * Math.min(Math.abs(turn), ASLANT);
  return { ...camera, yaw: camera.yaw + turn - aslant, pitch: z < -0.6 * length ? -0.6 : 0.5 };
}

/**
 * Where a ray meets the plane of a triangle; null if it runs along it.
 * @param {Vec3} origin
 * @param {Vec3} direction
 * @param {[Vec3, Vec3, Vec3]} triangle
 * @returns {Vec3 | null}
 */
export function meet(origin, direction, [a, b, c]) {
  const normal = cross(subtract(b, a), subtract(c, a));
  const slope = dot(normal, direction);
  if (Math.abs(slope) < 1e-12) return null;
  return add(origin, direction, dot(normal, subtract(a, origin)) / slope);
}

/** @param {Vec3} a @param {Vec3} b @param {number} t @returns {Vec3} */
export function add(a, b, t = 1) {
  return [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
export function subtract(a, b) {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** @param {Vec3} a @param {Vec3} b */
export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** @param {Vec3} a @param {Vec3} b @returns {Vec3} */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** @param {Vec3} a @param {number} t @returns {Vec3} */
function scaled(a, t) {
  return [a[0] * t, a[1] * t, a[2] * t];
}
