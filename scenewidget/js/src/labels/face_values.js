/**
 * Faces coloured by a number each: the values that Python gave, whether their label is right, or how doubtful
 * the border is that they lie at.
 */

import { readArray } from "../wire/wire.js";
import { confidenceColor } from "./confidence.js";

/** @typedef {import("../wire/wire.js").Model} Model */

export const RIGHT_COLOR = [205, 209, 214];
export const WRONG_COLOR = [208, 74, 46];
const WRONG = 2;

const ERROR_COLORS = Uint8Array.from({ length: 768 }, (_, i) =>
  i < 384 ? RIGHT_COLOR[i % 3] : WRONG_COLOR[i % 3],
);

/** From a border between two things to one that likely runs through one. */
export const BORDER_COLORS = Uint8Array.from(
  { length: 768 },
  (_, i) => confidenceColor(1 - Math.floor(i / 3) / 510)[i % 3],
);

/** @type {WeakMap<object, Uint16Array>} */
const known = new WeakMap();

/**
 * What is to be drawn of them now; null if there is nothing.
 * @param {Model} model
 * @returns {{ values: Uint16Array, colormap: Uint8Array } | null}
 */
export function faceValues(model) {
  if (model.get("color_by") === "errors") {
    const errors = readArray(model, "face_error");
    return errors && { values: spread(errors), colormap: ERROR_COLORS };
  }
  if (model.get("color_by") === "borders") {
    const borders = /** @type {Uint16Array | null} */ (readArray(model, "face_border"));
    return borders && { values: borders, colormap: BORDER_COLORS };
  }
  const values = /** @type {Uint16Array | null} */ (readArray(model, "face_value"));
  const colormap = /** @type {Uint8Array | null} */ (readArray(model, "colormap"));
  return values && colormap && { values, colormap };
}

/**
 * Verdicts as places on the colour map: 0 = unknown stays 0.
 * @param {import("../wire/wire.js").TypedArray} errors
 */
export function spread(errors) {
  const done = known.get(errors);
  if (done) return done;
  const values = Uint16Array.from(errors, (verdict) => (verdict === WRONG ? 65535 : verdict));
  known.set(errors, values);
  return values;
}
