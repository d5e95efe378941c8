/**
 * The round brush: faces that are seen under it become part of the segment on which the stroke began.
 *
 * A stroke that never leaves that segment would change nothing: it makes its faces a segment of their own. So a
 * mug that is melted into its table is painted out of it, and the next stroke that begins on the mug adds to it.
 */

import { rangesOf } from "../labels/painting.js";

/** Radius of the brush, CSS pixels. */
export const BRUSH_RADIUS = 12;

/** @param {Pick<import("./messages.js").Around, "view" | "segments" | "send">} around */
export function createPaint({ view, segments, send }) {
  /** @type {Set<number>} */
  let faces = new Set();
  /** @type {number | null} */
  let first = null;
  /** Whether the stroke has left the segment on which it began. */
  let hasLeft = false;

  function show() {
    segments.sketch = faces.size > 0 ? edit() : null;
    send({ kind: "segments" });
  }

  function edit() {
    return /** @type {const} */ ({
      kind: "paint",
      ranges: rangesOf(faces),
      onto_face: hasLeft ? first : null,
    });
  }

  function drop() {
    const hadAny = faces.size > 0;
    [faces, first, hasLeft] = [new Set(), null, false];
    segments.sketch = null;
    if (hadAny) send({ kind: "segments" });
  }

  return {
    /**
     * Take what lies under the brush.
     * @param {import("./gestures.js").Place} place
     * @param {number | null} from  face on which the stroke began
     */
    add(place, from) {
      first ??= from;
      const before = faces.size;
      for (const face of view.facesAround(place, BRUSH_RADIUS)) {
        if (faces.has(face)) continue;
        faces.add(face);
        // what is in the sketch already is in another segment as it is shown, but no new face is
        if (first !== null && face !== first && !hasLeft)
          hasLeft = segments.baseOf(face) !== segments.baseOf(first);
      }
      if (faces.size > before) show();
    },

    /** Forget the stroke. */
    drop,

    /** Do what is shown. */
    finish() {
      const done = faces.size > 0 ? edit() : null;
      drop();
      if (done) send({ kind: "edit", edit: done });
    },
  };
}
