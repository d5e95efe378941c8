/** What the status line says, in words. */

import { countSegments, describe, NONE } from "./partition.js";

/** @typedef {import("./partition.js").Partition} Partition */

/**
 * A face's segment with its size and confidence, and its part if that is something else.
 * @param {Partition} partition
 * @param {number} face
 * @param {{ level: string, names: Record<string, string>, confidence: Record<number, number> | null }} context
 */
export function describeFace(partition, face, { level, names, confidence }) {
  const { part, segment, partFaces, segmentFaces, segmentArea } = describe(partition, face);
  const isLabeled = segment !== NONE;
  const isSame = part === NONE || partFaces === segmentFaces;
  const sure = isLabeled ? confidence?.[segment] : undefined;
  return [
    isLabeled ? segmentTitle(segment, names) : "Unlabeled",
    isLabeled ? counted(segmentFaces, "face") : "",
    isLabeled && segmentArea > 0 ? `${area(segmentArea)} m²` : "",
    sure === undefined ? "" : `confidence ${sure.toFixed(2)}`,
    isSame ? "" : `${level} part of ${counted(partFaces, "face")}`,
  ]
    .filter(Boolean)
    .join("  ·  ");
}

/**
 * How much there is to see.
 * @param {number} nFaces
 * @param {Partition | null} partition
 */
export function summary(nFaces, partition) {
  const faces = counted(nFaces, "face");
  return partition ? `${faces}  ·  ${counted(countSegments(partition.atomSegment), "segment")}` : faces;
}

/** @param {number} segment @param {Record<string, string>} names */
export function segmentTitle(segment, names) {
  return names[segment] ? `Segment ${segment} (${names[segment]})` : `Segment ${segment}`;
}

/** @param {number} n @param {string} noun */
export function counted(n, noun) {
  return `${n.toLocaleString("en")} ${noun}${n === 1 ? "" : "s"}`;
}

/** @param {number} value */
function area(value) {
  return value >= 100 ? Math.round(value).toLocaleString("en") : value.toPrecision(2);
}
