/** The distance between two points of the scan, shown between them until the next is measured. */

import { localNumber } from "../labels/description.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */

/** @param {Pick<import("./messages.js").Around, "view" | "send">} around */
export function createMeasure({ view, send }) {
  /** @type {Vec3[]} */
  let points = [];
  /** @type {Vec3 | null} */
  let pointed = null;

  function show() {
    const ends = points.length === 1 && pointed ? [points[0], pointed] : points;
    const places = ends.map((end) => view.placeOf(end)).filter((place) => place !== null);
    const label = ends.length === 2 ? lengthOf(Math.hypot(...ends[1].map((x, k) => x - ends[0][k]))) : "";
    send({
      kind: "outline",
      places: places.length === ends.length ? places : [],
      isClosed: false,
      hasDots: true,
      label,
    });
  }

  return {
    get isEmpty() {
      return points.length === 0;
    },
    hint: () => (points.length === 1 ? "Distance: click the second point" : "Distance: click two points"),

    /** @param {import("./gestures.js").Place} place */
    mark(place) {
      const at = view.pointAt(place);
      if (!at) return;
      points = points.length === 1 ? [points[0], at] : [at];
      show();
      if (points.length === 2)
        send({
          kind: "remark",
          text: `Distance ${lengthOf(Math.hypot(...at.map((x, k) => x - points[0][k])))}`,
        });
    },

    /** @param {number | null} _ @param {Vec3 | null} at */
    point(_, at) {
      pointed = at;
      if (points.length === 1) show();
    },
    trace() {},
    renew() {
      if (points.length > 0) show();
    },
    finish() {},
    drop() {
      const wasShown = points.length > 0;
      points = [];
      if (wasShown) show();
    },
  };
}

/**
 * A length in words: metres, or centimetres below one.
 * @param {number} metres
 */
export function lengthOf(metres) {
  return metres < 1 ? `${localNumber(100 * metres, 1)} cm` : `${localNumber(metres, 2)} m`;
}
