/** Upright boxes of segments, as lines of the picture. */

/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {import("./camera.js").Place} Place */
/** @typedef {{ path: string, color: string, isPointed: boolean, label: string, top: Place | null }} BoxLines */

const WIDTH = 12; // numbers a box: its middle, and half of each of its three sides as a vector
const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1]);
const EDGES = CORNERS.flatMap((_, i) => [1, 2, 4].filter((bit) => !(i & bit)).map((bit) => [i, i | bit]));

/**
 * Corners of a box; null where the segment has none.
 * @param {Float32Array} boxes
 * @param {number} segment
 * @param {(point: Vec3) => Vec3} turned  from the mesh's own axes into those of the picture
 * @returns {Vec3[] | null}
 */
export function cornersOfBox(boxes, segment, turned) {
  const row = boxes.subarray(WIDTH * segment, WIDTH * segment + WIDTH);
  if (row.length < WIDTH || Number.isNaN(row[0])) return null;
  return CORNERS.map((signs) =>
    turned(
      /** @type {Vec3} */ (
        [0, 1, 2].map(
          (k) => row[k] + signs.reduce((sum, sign, axis) => sum + sign * row[3 + 3 * axis + k], 0),
        )
      ),
    ),
  );
}

/**
 * Its edges as an SVG path; those that reach behind the eye are left out.
 * @param {Array<Place | null>} corners
 */
export function pathOfBox(corners) {
  const round = (/** @type {number} */ x) => Math.round(10 * x) / 10;
  return EDGES.map(([a, b]) => [corners[a], corners[b]])
    .map(([a, b]) => (a && b ? `M${round(a.x)} ${round(a.y)}L${round(b.x)} ${round(b.y)}` : ""))
    .join("");
}

/**
 * Metres along the longer and the shorter side of the plan, and upwards.
 * @param {Float32Array} boxes
 * @param {number} segment
 */
export function sizesOfBox(boxes, segment) {
  return [0, 1, 2].map((axis) => {
    const from = WIDTH * segment + 3 + 3 * axis;
    return 2 * Math.hypot(...boxes.subarray(from, from + 3));
  });
}
