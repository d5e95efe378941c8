/** What the picture looks up by atom, for one way of colouring. */

import { confidenceColor, confidenceOf } from "./confidence.js";
import { hashedColor, packColor } from "./palette.js";
import { NONE } from "./partition.js";

/** @typedef {import("./partition.js").Partition} Partition */
/** @typedef {"segments" | "parts" | "confidence" | "normals" | "scan" | "shaded" | "values" | "errors" | "borders"} ColorBy */

/**
 * What the shader looks up by atom, four numbers each: segment, part, colour, and flags: 1 if it has a
 * colour, 2 if it is hidden.
 * @param {Partition} partition
 * @param {ColorBy} colorBy
 * @param {Uint8Array | null} [hidden]  1 for each atom that isn't drawn
 * @returns {Uint32Array}
 */
export function atomTable(partition, colorBy, hidden = null) {
  const { atomSegment, atomPart, segmentColors, atomConfidence } = partition;
  const table = new Uint32Array(4 * atomSegment.length);
  for (let atom = 0; atom < atomSegment.length; atom++) {
    const [segment, part] = [atomSegment[atom], atomPart[atom]];
    const key = colorBy === "parts" ? part : segment;
    table[4 * atom] = segment;
    table[4 * atom + 1] = part;
    table[4 * atom + 3] = 2 * (hidden?.[atom] ?? 0);
    if (key === NONE) continue;
    if (colorBy === "confidence") {
      const value = confidenceOf(atomConfidence?.[atom] ?? 0);
      if (value === null) continue;
      table[4 * atom + 2] = packColor(...confidenceColor(value));
      table[4 * atom + 3] += 1;
      continue;
    }
    const known = colorBy !== "parts" && 3 * segment + 2 < segmentColors.length;
    table[4 * atom + 2] = known
      ? packColor(segmentColors[3 * segment], segmentColors[3 * segment + 1], segmentColors[3 * segment + 2])
      : hashedColor(key);
    table[4 * atom + 3] += 1;
  }
  return table;
}
