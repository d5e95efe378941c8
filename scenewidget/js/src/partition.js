/**
 * Segments and levels over atoms: small tables, whatever the size of the mesh.
 *
 * Every face belongs to an atom, every atom to a segment and, at each level, to a part. NONE stands for -1.
 */

import { hashedColor, packColor } from "./palette.js";

export const NONE = 0xffffffff;

/**
 * @typedef {object} Partition
 * @property {Uint32Array} faceAtom
 * @property {Uint32Array} atomSegment
 * @property {Uint32Array} atomPart  of one level; the segments themselves if there are no levels
 * @property {Uint32Array} atomFaces  how many faces an atom has
 * @property {Uint8Array} segmentColors  three bytes a segment
 */

/** @typedef {"segments" | "parts" | "scan" | "shaded" | "values"} ColorBy */

/**
 * @param {object} arrays
 * @param {Uint32Array} arrays.faceAtom
 * @param {Uint32Array} arrays.atomSegment
 * @param {Uint32Array | null} arrays.atomPart  levels one after another
 * @param {Uint8Array | null} arrays.segmentColors
 * @param {number} level  index of the level; -1 = none
 * @returns {Partition}
 */
export function makePartition({ faceAtom, atomSegment, atomPart, segmentColors }, level) {
  const nAtoms = atomSegment.length;
  const isThere = atomPart !== null && level >= 0 && atomPart.length >= (level + 1) * nAtoms;
  return {
    faceAtom,
    atomSegment,
    atomPart: isThere ? atomPart.subarray(level * nAtoms, (level + 1) * nAtoms) : atomSegment,
    atomFaces: countFaces(faceAtom, nAtoms),
    segmentColors: segmentColors ?? new Uint8Array(0),
  };
}

/** @type {WeakMap<Uint32Array, Uint32Array>} */
const counts = new WeakMap();

/**
 * @param {Uint32Array} faceAtom
 * @param {number} nAtoms
 */
function countFaces(faceAtom, nAtoms) {
  let count = counts.get(faceAtom);
  if (!count || count.length !== nAtoms) {
    count = new Uint32Array(nAtoms);
    for (const atom of faceAtom) count[atom]++;
    counts.set(faceAtom, count);
  }
  return count;
}

/**
 * The part and the segment of a face, and their sizes in faces.
 * @param {Partition} partition
 * @param {number} face
 */
export function describe({ faceAtom, atomPart, atomSegment, atomFaces }, face) {
  const atom = faceAtom[face];
  const [part, segment] = [atomPart[atom], atomSegment[atom]];
  let [partFaces, segmentFaces] = [0, 0];
  for (let i = 0; i < atomFaces.length; i++) {
    if (atomPart[i] === part) partFaces += atomFaces[i];
    if (atomSegment[i] === segment) segmentFaces += atomFaces[i];
  }
  return { part, segment, partFaces, segmentFaces };
}

/**
 * What the shader looks up by atom, four numbers each: segment, part, colour, and 1 if it has a colour.
 * @param {Partition} partition
 * @param {ColorBy} colorBy
 * @returns {Uint32Array}
 */
export function atomTable({ atomSegment, atomPart, segmentColors }, colorBy) {
  const table = new Uint32Array(4 * atomSegment.length);
  for (let atom = 0; atom < atomSegment.length; atom++) {
    const [segment, part] = [atomSegment[atom], atomPart[atom]];
    const key = colorBy === "parts" ? part : segment;
    table[4 * atom] = segment;
    table[4 * atom + 1] = part;
    if (key === NONE) continue;
    const known = colorBy !== "parts" && 3 * segment + 2 < segmentColors.length;
    table[4 * atom + 2] = known
      ? packColor(segmentColors[3 * segment], segmentColors[3 * segment + 1], segmentColors[3 * segment + 2])
      : hashedColor(key);
    table[4 * atom + 3] = 1;
  }
  return table;
}
