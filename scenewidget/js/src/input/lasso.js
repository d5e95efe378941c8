/**
 * An outline around faces, drawn in one go or corner by corner: what lies within becomes a segment.
 *
 * It takes what is seen or, set to go through, everything behind as well; of all segments or of the one alone that
 * has the most faces within. Corners stay where they are on the scan while the camera turns.
 */

import { rangesOf } from "../labels/painting.js";
import { NONE } from "../labels/partition.js";
import { reached } from "../scene/surface.js";
import { isWithin } from "../scene/within.js";

/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("../scene/camera.js").Vec3} Vec3 */

const STEP = 4; // pixels between two places of a line drawn in one go
const NEAR = 9; // pixels from the first corner at which a click closes the outline
const NOTHING = "There is nothing within this outline";

/**
 * @param {Pick<import("./messages.js").Around, "view" | "segments" | "send"> & {
 *   options: Pick<import("./tool_options.js").Options, "current">,
 * }} around
 */
export function createLasso({ view, segments, options, send }) {
  /** Drawn in one go. @type {Place[]} */
  let line = [];
  /** Set one by one. @type {Vec3[]} */
  let corners = [];
  let request = 0;

  const placesOf = () =>
    line.length > 0
      ? line
      : /** @type {Place[]} */ (corners.map((corner) => view.placeOf(corner)).filter(Boolean));

  function show() {
    send({ kind: "outline", places: placesOf(), isClosed: true, hasDots: line.length === 0, label: "" });
    if (request) return;
    request = requestAnimationFrame(() => {
      request = 0;
      const faces = options.current.isThrough ? [] : within(placesOf());
      sketch(faces);
    });
  }

  /** @param {number[]} faces */
  function sketch(faces) {
    const before = segments.sketch;
    segments.sketch = faces.length > 0 ? editOf(faces) : null;
    if (before || segments.sketch) send({ kind: "segments" });
  }

  /** @param {number[]} faces */
  function editOf(faces) {
    return /** @type {const} */ ({ kind: "paint", ranges: rangesOf(faces), onto_face: null });
  }

  /** @param {Place[]} outline @returns {number[]} */
  function within(outline) {
    const { sight, surface, mesh } = view;
    if (outline.length < 3 || !sight || !mesh) return [];
    const isIn = (/** @type {number} */ face) => {
      const { x, y } = sight.placeOf(face);
      return isWithin(outline, x, y);
    };
    /** @type {number[]} */
    let faces = [];
    if (options.current.isThrough) {
      for (let face = 0; face < mesh.faces.length / 3; face++)
        if (view.isDrawn(face) && isIn(face)) faces.push(face);
    } else {
      const seen = view.facesWithin(outline);
      const counts = (/** @type {number} */ face) => isIn(face) && (seen.has(face) || sight.isSeen(face));
      faces = surface ? reached(surface, seen, counts, false) : [...seen].filter(counts);
    }
    return options.current.isOfOne ? ofOne(faces) : faces;
  }

  /** Those in the segment that has most of them. @param {number[]} faces */
  function ofOne(faces) {
    /** @type {Map<number, number>} */
    const counts = new Map();
    for (const face of faces) {
      const segment = segments.baseOf(face);
      if (segment !== NONE) counts.set(segment, (counts.get(segment) ?? 0) + 1);
    }
    const most = [...counts].sort(([, a], [, b]) => b - a)[0]?.[0];
    return faces.filter((face) => segments.baseOf(face) === most);
  }

  function drop() {
    cancelAnimationFrame(request);
    request = 0;
    const wasShown = line.length > 0 || corners.length > 0;
    [line, corners] = [[], []];
    if (wasShown) send({ kind: "outline", places: [], isClosed: true, hasDots: false, label: "" });
    sketch([]);
  }

  function finish() {
    const faces = within(placesOf());
    const wasShown = line.length > 0 || corners.length > 2;
    drop();
    if (faces.length > 0) send({ kind: "edit", edit: editOf(faces) });
    else if (wasShown) send({ kind: "remark", text: NOTHING });
  }

  return {
    get isEmpty() {
      return line.length === 0 && corners.length === 0;
    },
    hint() {
      if (corners.length === 0) return "Lasso: draw around faces, or click from corner to corner";
      return corners.length < 3
        ? "Lasso: click the next corner"
        : "Lasso: click the first corner, or Shift + Enter, to close the outline";
    },

    /** Draw on. @param {Place} place */
    trace({ x, y }) {
      const last = line[line.length - 1];
      if (last && Math.hypot(x - last.x, y - last.y) < STEP) return;
      line.push({ x, y });
      if (line.length > 1) show();
    },

    /** Set a corner, or close the outline at the first one. @param {Place} place */
    mark(place) {
      line = [];
      const first = corners.length > 2 ? view.placeOf(corners[0]) : null;
      if (first && Math.hypot(first.x - place.x, first.y - place.y) < NEAR) {
        finish();
        return;
      }
      corners.push(view.pointBefore(place));
      show();
    },

    /** The camera has moved, or options have changed. */
    renew() {
      if (line.length > 0 || corners.length > 0) show();
    },
    /** The pointer is elsewhere: nothing to show of it. */
    point() {},
    finish,
    drop,
  };
}
