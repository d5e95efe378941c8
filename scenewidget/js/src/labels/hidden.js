/** Which atoms aren't drawn, 1 for each: over other atoms of the same faces, and as faces, which never change. */

/** @typedef {Pick<import("./partition.js").Partition, "faceAtom" | "atomSegment">} Atoms */

/**
 * What is hidden, over other atoms of the same faces.
 * @param {Uint8Array | null} hidden
 * @param {Atoms | null} before
 * @param {Atoms | null} after
 */
export function carried(hidden, before, after) {
  if (!hidden || !before || !after) return null;
  if (before.faceAtom === after.faceAtom) return hidden;
  const next = new Uint8Array(after.atomSegment.length);
  for (let face = 0; face < after.faceAtom.length; face++) {
    next[after.faceAtom[face]] = hidden[before.faceAtom[face]];
  }
  return next;
}

/**
 * A face of each hidden atom.
 * @param {Uint8Array | null} hidden
 * @param {Uint32Array} faceAtom
 * @returns {number[]}
 */
export function facesOf(hidden, faceAtom) {
  if (!hidden) return [];
  const isMissing = hidden.slice();
  const faces = [];
  for (let face = 0; face < faceAtom.length; face++) {
    const atom = faceAtom[face];
    if (isMissing[atom] !== 1) continue;
    isMissing[atom] = 0;
    faces.push(face);
  }
  return faces;
}

/**
 * How many segments are hidden, at least in part.
 * @param {Uint8Array | null} hidden
 * @param {Atoms | null} partition
 */
export function countHidden(hidden, partition) {
  if (!hidden || !partition) return 0;
  return new Set(partition.atomSegment.filter((_, atom) => hidden[atom] === 1)).size;
}

/**
 * What to hide so that one segment more is, or one less if it was.
 * @param {Uint8Array | null} hidden
 * @param {Uint32Array} atomSegment
 * @param {number} segment
 * @returns {(atom: number) => boolean}
 */
export function toggledHidden(hidden, atomSegment, segment) {
  const was = (/** @type {number} */ atom) => hidden?.[atom] === 1;
  const isHidden = hidden !== null && atomSegment.every((other, atom) => other !== segment || was(atom));
  return isHidden
    ? (atom) => was(atom) && atomSegment[atom] !== segment
    : (atom) => was(atom) || atomSegment[atom] === segment;
}

/**
 * What to hide so that only one segment is shown; nothing, null, if that is so already.
 * @param {Uint8Array | null} hidden
 * @param {Uint32Array} atomSegment
 * @param {number} segment
 * @returns {((atom: number) => boolean) | null}
 */
export function othersHidden(hidden, atomSegment, segment) {
  const isAlone =
    hidden !== null && atomSegment.every((other, atom) => (other !== segment) === (hidden[atom] === 1));
  return isAlone ? null : (atom) => atomSegment[atom] !== segment;
}
