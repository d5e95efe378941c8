/** What a cut would divide off: its faces as Python sends them, and the tables in which it is a segment. */

/**
 * Faces out of a bit for each.
 * @param {number} first
 * @param {{ buffer: ArrayBuffer, byteOffset: number, byteLength: number }} bits
 * @returns {number[]}
 */
export function facesOf(first, { buffer, byteOffset, byteLength }) {
  const bytes = new Uint8Array(buffer, byteOffset, byteLength);
  const faces = [];
  for (let i = 0; i < 8 * byteLength; i++) if ((bytes[i >> 3] >> (i & 7)) & 1) faces.push(first + i);
  return faces;
}

/**
 * Tables in which some faces are a segment of their own; atoms that are only partly in it become two.
 * @param {import("./partition.js").Tables} tables
 * @param {number[]} faces
 * @param {number} segment
 * @returns {import("./partition.js").Tables}
 */
export function divided(tables, faces, segment) {
  const faceAtom = tables.faceAtom.slice();
  const nBefore = tables.atomSegment.length;
  /** @type {Map<number, number>} */
  const twins = new Map();
  for (const face of faces) {
    const atom = faceAtom[face];
    const twin = twins.get(atom) ?? nBefore + twins.size;
    twins.set(atom, twin);
    faceAtom[face] = twin;
  }
  const parents = [...twins.keys()];
  /** @template {Uint32Array | Uint16Array} Row @param {Row} row @returns {Row} */
  const grown = (row) => {
    const next = /** @type {Row} */ (new /** @type {any} */ (row.constructor)(nBefore + parents.length));
    next.set(row);
    next.set(
      parents.map((atom) => row[atom]),
      nBefore,
    );
    return next;
  };
  const rows = Array.from({ length: (tables.atomPart?.length ?? 0) / nBefore }, (_, level) =>
    grown(/** @type {Uint32Array} */ (tables.atomPart).subarray(level * nBefore, (level + 1) * nBefore)),
  );
  return {
    ...tables,
    faceAtom,
    atomSegment: grown(tables.atomSegment).fill(segment, nBefore),
    atomPart: tables.atomPart && Uint32Array.from(rows.flatMap((row) => [...row])),
    atomConfidence: tables.atomConfidence ? grown(tables.atomConfidence) : null,
  };
}
