/** A scan turned so that z is up, as everything else here takes it to be. */

/** @typedef {import("./camera.js").Vec3} Vec3 */

/** @typedef {[Vec3, Vec3, Vec3]} Vec3Axes */

const NAMES = ["x", "y", "z"];

/**
 * Right-handed axes of the upright room in the mesh's own coordinates; along the mesh's if up is one of them.
 * @param {Vec3} up  a unit vector
 * @returns {[Vec3, Vec3, Vec3]}
 */
export function uprightAxes([x, y, z]) {
  const k = [x, y, z].map(Math.abs).indexOf(Math.max(Math.abs(x), Math.abs(y), Math.abs(z)));
  /** @type {Vec3} */
  const first = [0, 0, 0];
  first[(k + 1) % 3] = 1;
  const along = first[0] * x + first[1] * y + first[2] * z;
  const rest = first.map((value, i) => value - along * [x, y, z][i]);
  const length = Math.hypot(...rest);
  const [a, b, c] = rest.map((value) => value / length);
  return [
    [a, b, c],
    [y * c - z * b, z * a - x * c, x * b - y * a],
    [x, y, z],
  ];
}

/**
 * Points in the axes of the upright room.
 * @param {Float32Array} points
 * @param {Vec3} up
 * @returns {Float32Array}  the same array if up is z
 */
export function upright(points, up) {
  if (up[2] > 1 - 1e-9) return points;
  const [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = uprightAxes(up);
  const turned = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) {
    const [x, y, z] = [points[i], points[i + 1], points[i + 2]];
    turned[i] = ax * x + ay * y + az * z;
    turned[i + 1] = bx * x + by * y + bz * z;
    turned[i + 2] = cx * x + cy * y + cz * z;
  }
  return turned;
}

/**
 * Normals, in rows of four signed bytes of which the last is kept, in the axes of the upright room.
 * @param {Int8Array} normals
 * @param {Vec3} up
 */
export function uprightNormals(normals, up) {
  if (up[2] > 1 - 1e-9) return normals;
  const axes = uprightAxes(up);
  const turned = new Int8Array(normals);
  for (let i = 0; i < normals.length; i += 4)
    for (let k = 0; k < 3; k++) {
      const [a, b, c] = axes[k];
      turned[i + k] = Math.round(a * normals[i] + b * normals[i + 1] + c * normals[i + 2]);
    }
  return turned;
}

/**
 * What the horizontal axes are called in the mesh's own coordinates, such as "+x"; "" if along none of them.
 * @param {Vec3} up
 */
export function axisNames(up) {
  return uprightAxes(up)
    .slice(0, 2)
    .map((axis) => {
      const k = axis.findIndex((value) => Math.abs(value) > 1 - 1e-6);
      return k < 0 ? "" : (axis[k] > 0 ? "+" : "−") + NAMES[k];
    });
}

/**
 * A vector of the upright room in the mesh's own coordinates.
 * @param {Vec3} vector
 * @param {[Vec3, Vec3, Vec3] | null} axes  of the room; null: they are the mesh's own
 * @returns {Vec3}
 */
export function ownVector([x, y, z], axes) {
  if (!axes) return [x, y, z];
  const [a, b, c] = axes;
  return /** @type {Vec3} */ ([0, 1, 2].map((k) => x * a[k] + y * b[k] + z * c[k]));
}
