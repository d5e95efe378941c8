/**
 * How sure a segmentation is, by atom: as it crosses from Python, as a colour, and as a mean over segments.
 *
 * The colours run from a strong vermilion, where one should look, to a pale blue grey, ever lighter, so that
 * everybody can tell them apart. Confidence is a probability, and mostly high: up to one half, where a face
 * rather belongs elsewhere, all are as strong, which leaves more colours to those above.
 */

import { oklab } from "./palette.js";
import { NONE } from "./partition.js";

/** Up to which the colour is the same. */
export const UNLIKELY = 0.5;
const UNSURE = [0.56, 0.14, 0.09]; // Oklab
const SURE = [0.93, -0.012, -0.022];

/** From the number sent, 0 to 1; null = none. @param {number} code  0 = none, else 1 to 65535 */
export function confidenceOf(code) {
  return code === 0 ? null : (code - 1) / 65534;
}

/**
 * sRGB bytes.
 * @param {number} value  0 to 1
 * @returns {[number, number, number]}
 */
export function confidenceColor(value) {
  const t = Math.max(0, (value - UNLIKELY) / (1 - UNLIKELY));
  const [lightness, a, b] = UNSURE.map((low, k) => low + t * (SURE[k] - low));
  return oklab(lightness, a, b);
}

/**
 * Mean over the area of each segment that has one, by number.
 * @param {import("./partition.js").Partition} partition
 * @returns {Record<number, number>}
 */
export function meanConfidence({ atomSegment, atomArea, atomConfidence }) {
  /** @type {Record<number, number>} */
  const areas = {};
  /** @type {Record<number, number>} */
  const sums = {};
  for (let atom = 0; atom < atomSegment.length; atom++) {
    const value = confidenceOf(atomConfidence?.[atom] ?? 0);
    const segment = atomSegment[atom];
    if (value === null || segment === NONE) continue;
    areas[segment] = (areas[segment] ?? 0) + atomArea[atom];
    sums[segment] = (sums[segment] ?? 0) + value * atomArea[atom];
  }
  for (const segment in sums) sums[segment] /= areas[segment] || 1;
  return sums;
}
