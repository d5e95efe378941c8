/** What the status line says, in words. */

import { countSegments, describe, NONE } from "./partition.js";

/** @typedef {import("./partition.js").Partition} Partition */

const LOCALE = globalThis.navigator?.language || "en";

/**
 * A face's segment with its size and confidence, and its part if that is something else.
 * @param {Partition} partition
 * @param {number} face
 * @param {object} context
 * @param {string} context.level
 * @param {Record<string, string>} context.names
 * @param {Record<number, number> | null} context.confidence
 * @param {string} context.noun  what faces are called
 */
export function describeFace(partition, face, { level, names, confidence, noun }) {
  const { part, segment, partFaces, segmentFaces, segmentArea } = describe(partition, face);
  const isLabeled = segment !== NONE;
  const isSame = part === NONE || partFaces === segmentFaces;
  const sure = isLabeled ? confidence?.[segment] : undefined;
  return [
    isLabeled ? segmentTitle(segment, names) : "Unlabeled",
    isLabeled ? counted(segmentFaces, noun) : "",
    isLabeled && segmentArea > 0 ? `${area(segmentArea)} m²` : "",
    sure === undefined ? "" : `confidence ${localNumber(sure, 2)}`,
    isSame ? "" : `${level} part of ${counted(partFaces, noun)}`,
  ]
    .filter(Boolean)
    .join("  ·  ");
}

/**
 * How much there is to see.
 * @param {number} nFaces
 * @param {Partition | null} partition
 * @param {string} noun  what faces are called
 */
export function summary(nFaces, partition, noun) {
  const faces = counted(nFaces, noun);
  return partition ? `${faces}  ·  ${counted(countSegments(partition.atomSegment), "segment")}` : faces;
}

/** @param {number} segment @param {Record<string, string>} names */
export function segmentTitle(segment, names) {
  return names[segment] ? `Segment ${segment} (${names[segment]})` : `Segment ${segment}`;
}

/**
 * A number as the reader writes it, with so many decimals.
 * @param {number} value
 * @param {number} [decimals]
 */
export function localNumber(value, decimals = 0) {
  return value.toLocaleString(LOCALE, { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

/** @param {number} n @param {string} noun */
export function counted(n, noun) {
  return `${localNumber(n)} ${noun}${n === 1 ? "" : "s"}`;
}

/** @param {number} value */
function area(value) {
  const digits = { minimumSignificantDigits: 2, maximumSignificantDigits: 2 };
  return value >= 100 ? localNumber(value) : value.toLocaleString(LOCALE, digits);
}
