/**
 * A plane through a segment: by three points on it, or by the wall that it leans on.
 *
 * The segment is the one under the first point. While the last point is looked for, what the plane would divide
 * off, the smaller side, is shown as if it were done.
 */

import { rangesOf } from "../labels/painting.js";
import { NONE } from "../labels/partition.js";
import { reached } from "../scene/surface.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */
/** @typedef {{ point: Vec3, normal: Vec3 }} Plane */

const WALL = 0.15; // metres around a point that say how the wall lies there
const FLATTEST = 0.05; // of a triangle's longest side that it is high, or its points lie on a line
const ON_A_LINE = "The three points lie on a line: no plane goes through them alone";
const NO_WALL = "How this surface lies can't be told here: take three points";
const ONE_SIDE = "All of the segment lies on one side of this plane";

/**
 * @param {Pick<import("./messages.js").Around, "view" | "segments" | "send"> & {
 *   options: Pick<import("./tool_options.js").Options, "current">,
 * }} around
 */
export function createSlice({ view, segments, options, send }) {
  /** @type {Vec3[]} */
  let points = [];
  /** Of the segment to be cut. @type {number | null} */
  let first = null;
  /** Where the pointer is. @type {{ face: number, at: Vec3 } | null} */
  let pointed = null;
  let request = 0;

  const needed = () => (options.current.plane === "wall" ? 2 : 3);

  /**
   * The plane that is given, with one more point.
   * @param {{ face: number, at: Vec3 }} more
   * @returns {Plane | null}
   */
  function planeWith({ face, at }) {
    return options.current.plane === "wall" ? wallAt(face, at) : planeThrough([...points, at]);
  }

  /** The plane of a wall, so far in front of it as the options say. @param {number} face @param {Vec3} at */
  function wallAt(face, at) {
    const { sight, surface, mesh } = view;
    if (!sight || !surface || !mesh) return null;
    const around = reached(surface, [face], (other) => sight.awayFrom(other, at) <= WALL ** 2, true);
    const flat = fitted(mesh, around.length > 0 ? around : [face]);
    const offset = options.current.offset / 100;
    return (
      flat && { ...flat, point: /** @type {Vec3} */ (flat.point.map((x, k) => x + offset * flat.normal[k])) }
    );
  }

  /** Faces of the segment on the smaller side of a plane, and one of the other. @param {Plane} plane */
  function divided({ point, normal }) {
    const { mesh } = view;
    if (first === null || !mesh) return null;
    const { vertices, faces } = mesh;
    const home = segments.baseOf(first);
    const level = 3 * (point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]);
    /** @type {[number[], number[]]} */
    const sides = [[], []];
    for (let face = 0; face < faces.length / 3; face++) {
      if (segments.baseOf(face) !== home) continue;
      let height = 0;
      for (let i = 3 * face; i < 3 * face + 3; i++) {
        const v = 3 * faces[i];
        height += vertices[v] * normal[0] + vertices[v + 1] * normal[1] + vertices[v + 2] * normal[2];
      }
      sides[height > level ? 1 : 0].push(face);
    }
    const [less, more] = sides[0].length < sides[1].length ? sides : [sides[1], sides[0]];
    return less.length > 0 ? { off: less, kept: more[0] } : null;
  }

  function show() {
    const shown = pointed && points.length > 0 ? [...points, pointed.at] : points;
    const places = shown.map((point) => view.placeOf(point)).filter((place) => place !== null);
    send({ kind: "outline", places, isClosed: true, hasDots: true, label: "" });
    cancelAnimationFrame(request);
    request = requestAnimationFrame(() => {
      request = 0;
      const plane = pointed && points.length === needed() - 1 ? planeWith(pointed) : null;
      const sides = plane && divided(plane);
      sketch(sides ? sides.off : []);
    });
  }

  /** @param {number[]} faces */
  function sketch(faces) {
    const before = segments.sketch;
    segments.sketch = faces.length > 0 ? { kind: "paint", ranges: rangesOf(faces), onto_face: null } : null;
    if (before || segments.sketch) send({ kind: "segments" });
  }

  function drop() {
    cancelAnimationFrame(request);
    request = 0;
    const wasShown = points.length > 0;
    [points, first] = [[], null];
    if (wasShown) send({ kind: "outline", places: [], isClosed: true, hasDots: false, label: "" });
    sketch([]);
  }

  /** @param {{ face: number, at: Vec3 }} last */
  function finish(last) {
    const plane = planeWith(last);
    const sides = plane && divided(plane);
    const text = plane ? ONE_SIDE : options.current.plane === "wall" ? NO_WALL : ON_A_LINE;
    drop();
    if (!plane || !sides) {
      send({ kind: "remark", text });
      return;
    }
    const [point, normal] = [view.ownVector(plane.point), view.ownVector(plane.normal)];
    send({
      kind: "edit",
      edit: { kind: "slice", face: sides.kept, point, normal, off: rangesOf(sides.off) },
    });
  }

  return {
    get isEmpty() {
      return points.length === 0;
    },
    hint() {
      if (options.current.plane === "wall") {
        return points.length === 0
          ? "Slice: click the segment to cut"
          : "Slice: now the wall or the surface that it leans on";
      }
      const which = ["three points of a plane on a segment", "the second point", "the third point"];
      return `Slice: click ${which[points.length]}`;
    },

    /** @param {import("./gestures.js").Place} place */
    mark(place) {
      const [face, at] = [view.faceAt(place), view.pointAt(place)];
      if (face === null || at === null) return;
      if (points.length === needed() - 1) {
        finish({ face, at });
        return;
      }
      if (points.length === 0) {
        if (segments.baseOf(face) === NONE) {
          send({ kind: "remark", text: "This surface is unlabeled: there is no segment to slice" });
          return;
        }
        first = face;
      }
      points.push(at);
      show();
    },

    /** @param {number | null} face @param {Vec3 | null} at */
    point(face, at) {
      pointed = face === null || at === null ? null : { face, at };
      if (points.length > 0) show();
    },
    trace() {},
    renew() {
      if (points.length > 0) show();
    },
    finish() {},
    drop,
  };
}

/**
 * The plane through three points; null if they lie on a line.
 * @param {Vec3[]} points
 * @returns {Plane | null}
 */
export function planeThrough([a, b, c]) {
  const [u, v] = [b, c].map((end) => end.map((x, k) => x - a[k]));
  const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const longest = Math.max(Math.hypot(...u), Math.hypot(...v), Math.hypot(...c.map((x, k) => x - b[k])));
  const size = Math.hypot(...normal);
  if (!(size > FLATTEST * longest ** 2)) return null;
  return { point: a, normal: /** @type {Vec3} */ (normal.map((x) => x / size)) };
}

/**
 * How faces lie as a whole: the mean of their middles and of their normals, by area; null if they face all ways.
 * @param {{ vertices: Float32Array, faces: Uint32Array }} mesh
 * @param {number[]} some
 * @returns {Plane | null}
 */
export function fitted({ vertices, faces }, some) {
  const [point, normal] = [
    [0, 0, 0],
    [0, 0, 0],
  ];
  let total = 0;
  for (const face of some) {
    const [a, b, c] = [0, 1, 2].map((k) => {
      const v = 3 * faces[3 * face + k];
      return [vertices[v], vertices[v + 1], vertices[v + 2]];
    });
    const [u, v] = [b, c].map((end) => end.map((x, k) => x - a[k]));
    const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const area = Math.hypot(...cross);
    total += area;
    for (let k = 0; k < 3; k++) {
      normal[k] += cross[k];
      point[k] += (area * (a[k] + b[k] + c[k])) / 3;
    }
  }
  const size = Math.hypot(...normal);
  if (!(size > 0)) return null;
  return {
    point: /** @type {Vec3} */ (point.map((x) => x / total)),
    normal: /** @type {Vec3} */ (normal.map((x) => x / size)),
  };
}
