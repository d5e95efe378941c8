/** The segments as a list has them: one row each, in some order. */

import { NONE } from "./partition.js";

/** @typedef {import("./partition.js").Partition} Partition */

/**
 * @typedef {object} Row
 * @property {number} segment  NONE = all that is unlabeled
 * @property {string} name  "" if it has none
 * @property {string} color  as in style sheets
 * @property {number | null} whole  the segment that it is a part of
 * @property {number} faces
 * @property {number} area
 * @property {number | null} confidence  0 to 1
 * @property {"none" | "some" | "all"} hidden  how much of it isn't drawn
 */

/** @typedef {"name" | "faces" | "area" | "confidence"} Column */
/** @typedef {{ column: Column, isDescending: boolean }} Order */

/** Which way a column is sorted first: the largest segments, the least certain ones. @type {Record<Column, boolean>} */
export const FIRST_DESCENDING = { name: false, faces: true, area: true, confidence: false };

/**
 * A row for each segment that has faces, and one for what is unlabeled if anything is.
 * @param {Partition} partition
 * @param {object} context
 * @param {Record<string, string>} context.names
 * @param {Record<string, number>} context.groups  what a segment is a part of
 * @param {Record<number, number> | null} context.confidence  by segment
 * @param {Uint8Array | null} context.hidden  1 for each atom that isn't drawn
 * @returns {Row[]}
 */
export function segmentRows(partition, { names, groups, confidence, hidden }) {
  const { atomSegment, atomFaces, atomArea, segmentColors } = partition;
  /** @type {Map<number, { faces: number, area: number, hiddenFaces: number }>} */
  const sums = new Map();
  for (let atom = 0; atom < atomSegment.length; atom++) {
    let sum = sums.get(atomSegment[atom]);
    if (!sum) {
      sum = { faces: 0, area: 0, hiddenFaces: 0 };
      sums.set(atomSegment[atom], sum);
    }
    sum.faces += atomFaces[atom];
    sum.area += atomArea[atom];
    if (hidden?.[atom]) sum.hiddenFaces += atomFaces[atom];
  }
  return [...sums].map(([segment, { faces, area, hiddenFaces }]) => {
    const rgb = segment === NONE ? [] : segmentColors.subarray(3 * segment, 3 * segment + 3);
    return {
      segment,
      name: segment === NONE ? "" : (names[segment] ?? ""),
      color: rgb.length === 3 ? `rgb(${rgb.join(" ")})` : "",
      whole: sums.has(groups[segment]) ? groups[segment] : null,
      faces,
      area,
      confidence: segment === NONE ? null : (confidence?.[segment] ?? null),
      hidden: hiddenFaces === 0 ? "none" : hiddenFaces < faces ? "some" : "all",
    };
  });
}

/**
 * Rows in order; equal ones by number, those without a value and what is unlabeled last. Parts follow their whole.
 * @param {Row[]} rows
 * @param {Order} order
 * @returns {Row[]}
 */
export function sorted(rows, { column, isDescending }) {
  const sign = isDescending ? -1 : 1;
  const ordered = [...rows].sort((a, b) => {
    const last = Number(a.segment === NONE) - Number(b.segment === NONE);
    const missing = Number(isMissing(a[column])) - Number(isMissing(b[column]));
    return last || missing || sign * compared(a[column], b[column]) || a.segment - b.segment;
  });
  const parts = ordered.filter(({ whole }) => whole !== null);
  const others = ordered.filter(({ whole }) => whole === null);
  return others.flatMap((row) => [row, ...parts.filter(({ whole }) => whole === row.segment)]);
}

/** @param {string | number | null} value */
function isMissing(value) {
  return value === null || value === "";
}

/** @param {string | number | null} a @param {string | number | null} b */
function compared(a, b) {
  if (typeof a === "string" && typeof b === "string") return a.localeCompare(b, "en", { numeric: true });
  return Number(a) - Number(b);
}
