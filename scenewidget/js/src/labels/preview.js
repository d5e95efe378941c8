/**
 * What is shown while somebody still chooses: a coarse result that Python sends, or another granularity,
 * which the browser cuts by itself out of the nested family of segmentations.
 */

import { hear } from "../wire/channel.js";
import { on } from "../wire/listen.js";
import { readArray } from "../wire/wire.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {{ faceAtom: Uint32Array, atomSegment: Uint32Array, segmentColors: Uint8Array }} Tables */

export class Preview {
  /**
   * @param {Model} model
   * @param {() => void} onChange
   * @param {AbortSignal} signal
   */
  constructor(model, onChange, signal) {
    this.model = model;
    /** Segments that the slider asks for, while it moves and until the result is there. @type {number | null} */
    this.granularity = null;
    this.isResting = false;
    const hearSlider = (/** @type {any} */ { kind, n, isResting }) => {
      if (kind !== "granularity") return;
      this.granularity = n;
      this.isResting = isResting;
      onChange();
    };
    hear(() => model.get("_channel"), hearSlider, signal);
    const settle = () => {
      if (!this.isResting) return;
      this.granularity = null;
      onChange();
    };
    on(model, "change:revision", settle, signal);
    on(model, "change:busy", () => model.get("busy") || settle(), signal);
    const onMessage = (/** @type {any} */ message) => {
      if (message?.kind === "end_preview") settle(); // what was asked for is what there is, or can't be
    };
    on(model, "msg:custom", onMessage, signal);
  }

  /** What to show instead of the segments; null if nothing. @returns {Tables | null} */
  tables() {
    const { model } = this;
    const merges = /** @type {Uint32Array | null} */ (readArray(model, "family_merges"));
    const pieces = readArray(model, "face_piece");
    const colors = /** @type {Uint8Array | null} */ (readArray(model, "family_colors"));
    if (this.granularity !== null && merges && pieces && colors) {
      const atomSegment = cutFamily(colors.length / 3, merges, this.granularity);
      return { faceAtom: widened(pieces), atomSegment, segmentColors: colors };
    }
    const items = readArray(model, "face_item");
    const atomSegment = /** @type {Uint32Array | null} */ (readArray(model, "preview_segment"));
    const segmentColors = /** @type {Uint8Array | null} */ (readArray(model, "preview_colors"));
    if (!model.get("_is_preview") || !items || !atomSegment || !segmentColors) return null;
    return { faceAtom: widened(items), atomSegment, segmentColors };
  }
}

/**
 * The piece that stands for the segment of each piece, with so many segments or as near as it gets. The last
 * entry, for faces without a piece, is NONE.
 * @param {number} nPieces
 * @param {Uint32Array} merges  two a step: the one that stands for both, and the other
 * @param {number} nSegments
 */
export function cutFamily(nPieces, merges, nSegments) {
  const group = Uint32Array.from({ length: nPieces + 1 }, (_, i) => (i < nPieces ? i : 0xffffffff));
  const nSteps = Math.max(0, Math.min(merges.length / 2, nPieces - nSegments));
  for (let step = nSteps - 1; step >= 0; step--) group[merges[2 * step + 1]] = group[merges[2 * step]];
  return group;
}

/** @type {WeakMap<object, Uint32Array>} */
const wide = new WeakMap();

/** @param {import("../wire/wire.js").TypedArray} array */
function widened(array) {
  if (array instanceof Uint32Array) return array;
  const known = wide.get(array) ?? Uint32Array.from(array);
  wide.set(array, known);
  return known;
}
