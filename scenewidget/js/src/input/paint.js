/**
 * The round brush: faces that are seen under it become part of the segment on which the stroke began.
 *
 * A stroke that never leaves that segment would change nothing: it makes its faces a segment of their own. So a
 * mug that is melted into its table is painted out of it, and the next stroke that begins on the mug adds to it.
 * Set to take away, it gives faces of that segment alone to the one around them that they touch most.
 *
 * A brush that sticks to the surface takes what it reaches from where the stroke began without crossing a crease
 * or an edge between colours: the table under the mug stays what it is, however far the brush hangs over.
 */

import { rangesOf } from "../labels/painting.js";
import { NONE } from "../labels/partition.js";
import { nowhere } from "../scene/area.js";
import { reached, specks } from "../scene/surface.js";

/** @typedef {import("./gestures.js").Place} Place */

/**
 * @param {Pick<import("./messages.js").Around, "view" | "segments" | "send"> & {
 *   options: Pick<import("./tool_options.js").Options, "current">,
 * }} around
 */
export function createPaint({ view, segments, options, send }) {
  /** @type {Set<number>} */
  let faces = new Set();
  /** @type {number | null} */
  let first = null;
  /** Whether the stroke has left the segment on which it began. */
  let hasLeft = false;
  /** Whether the stroke began without sticking, or went on so. */
  let isLoose = false;
  /** @type {import("../labels/painting.js").Draft} */
  let draft = { faceAtom: null };
  /** Where the stroke has grown since it was last shown. */
  let area = nowhere();
  /** What it was shown with: another picture, or another segment that it goes to, and all of it looks different. */
  const shown = {
    sight: /** @type {import("../scene/sight.js").Sight | null} */ (null),
    onto: /** @type {number | null} */ (null),
  };

  /** Show the stroke, with the next frame: a fast pointer moves several times in between. */
  function show() {
    const sketch = edit();
    const { sight } = view;
    const isSame = sight !== null && sight === shown.sight && sketch.onto_face === shown.onto;
    segments.sketch = { ...sketch, draft };
    segments.sketchArea = isSame && !view.isCloud ? area : null;
    [shown.sight, shown.onto] = [sight, sketch.onto_face];
    area = nowhere();
    send({ kind: "segments" });
  }

  function edit() {
    const { takesAway } = options.current;
    const onto = takesAway ? around() : hasLeft ? first : null;
    return /** @type {const} */ ({ kind: "paint", ranges: rangesOf(faces), onto_face: onto });
  }

  /** A face of the other segment that the stroke touches most; null if it touches none. */
  function around() {
    const { surface } = view;
    const home = first === null ? NONE : segments.baseOf(first);
    /** @type {Map<number, { face: number, n: number }>} */
    const touched = new Map();
    for (const face of surface ? faces : []) {
      for (let side = 3 * face; side < 3 * face + 3; side++) {
        const next = surface?.neighbors[side] ?? -1;
        const segment = next < 0 || faces.has(next) ? home : segments.baseOf(next);
        if (segment === home || segment === NONE) continue;
        const known = touched.get(segment);
        if (known) known.n++;
        else touched.set(segment, { face: next, n: 1 });
      }
    }
    const most = [...touched.values()].sort((a, b) => b.n - a.n);
    return most[0]?.face ?? null;
  }

  function drop() {
    view.forget(show);
    const hadAny = faces.size > 0;
    [faces, first, hasLeft, isLoose] = [new Set(), null, false, false];
    [draft, area, shown.sight] = [{ faceAtom: null }, nowhere(), null];
    segments.sketch = null;
    if (hadAny) send({ kind: "segments" });
  }

  /**
   * What lies under the brush and is to be taken.
   * @param {Place} place
   * @param {boolean} isFree  from the surface
   */
  function under(place, isFree) {
    const { sight, surface } = view;
    const middle = view.pointAt(place);
    const radius = radiusAt(view, options.current, place);
    if (!sight || (!surface && !view.isCloud) || radius === null) return [];
    const seen = view.facesAround(place, radius);
    const { unit, sticks } = options.current;
    const reach = options.current.radius.cm / 100;
    if (unit === "cm" && middle)
      for (const face of seen) if (sight.awayFrom(face, middle) > (2 * reach) ** 2) seen.delete(face);
    const isUnder = (/** @type {number} */ face) => {
      if (unit === "cm") return middle !== null && sight.awayFrom(face, middle) <= reach ** 2;
      const { x, y } = sight.placeOf(face);
      return (x - place.x) ** 2 + (y - place.y) ** 2 <= radius ** 2;
    };
    const counts = (/** @type {number} */ face) =>
      isOfHome(face) && (seen.has(face) || (isUnder(face) && sight.isSeen(face)));
    if (!surface) return [...seen].filter(counts); // points have no creases that are known here
    const isBound = sticks && !isFree;
    isLoose ||= !isBound;
    const begun = faces.size > 0 ? [...seen].filter((face) => faces.has(face)) : [first ?? -1];
    return reached(surface, isBound ? begun.filter((face) => face >= 0) : seen, counts, isBound);
  }

  /** Whether the stroke may take a face: to take away, of the segment it began on alone. @param {number} face */
  function isOfHome(face) {
    return !options.current.takesAway || segments.baseOf(face) === segments.baseOf(first ?? face);
  }

  return {
    /**
     * Take what lies under the brush.
     * @param {Place & { isFree?: boolean }} place  isFree: it doesn't stick to the surface for now
     * @param {number | null} from  face on which the stroke began
     */
    add(place, from) {
      first ??= from;
      const before = faces.size;
      for (const face of under(place, place.isFree ?? false)) {
        if (faces.has(face)) continue;
        faces.add(face);
        if (!view.isCloud) view.sight?.widen(area, face);
        // what is in the sketch already is in another segment as it is shown, but no new face is
        if (first !== null && face !== first && !hasLeft)
          hasLeft = segments.baseOf(face) !== segments.baseOf(first);
      }
      if (faces.size > before) view.prepare(show);
    },

    /** Forget the stroke. */
    drop,

    /** Do what is shown. */
    finish() {
      const { surface } = view;
      if (surface && !isLoose) for (const face of specks(surface, faces, isOfHome)) faces.add(face);
      const done = faces.size > 0 ? edit() : null;
      drop();
      if (done) send({ kind: "edit", edit: done });
    },
  };
}

/**
 * Radius of the brush in pixels of the picture; null where there is no surface to measure it on.
 * @param {Pick<import("../scene/viewer.js").Viewer, "sight" | "pointAt">} view
 * @param {import("./tool_options.js").ToolOptions} options
 * @param {Place} place
 */
export function radiusAt(view, { unit, radius }, place) {
  if (unit === "px") return radius.px;
  const point = view.pointAt(place);
  const pixel = point && view.sight?.pixelAt(point);
  return pixel ? radius.cm / 100 / pixel : null;
}
