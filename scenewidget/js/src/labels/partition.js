/**
 * Segments and levels over atoms: small tables, whatever the size of the mesh.
 *
 * Every face belongs to an atom, every atom to a segment and, at each level, to a part. NONE stands for -1.
 */

export const NONE = 0xffffffff;

/**
 * @typedef {object} Partition
 * @property {Uint32Array} faceAtom
 * @property {Uint32Array} atomSegment
 * @property {Uint32Array} atomPart  of one level; the segments themselves if there are no levels
 * @property {Uint32Array} atomFaces  how many faces an atom has
 * @property {Float64Array} atomArea  in squares of the mesh's unit
 * @property {Uint8Array} segmentColors  three bytes a segment
 * @property {Uint16Array | null} atomConfidence  0 = none, else 1 to 65535
 */

/** @typedef {{ face: number, part: number, segment: number }} Hit  what lies at a place of the picture */

/**
 * @typedef {object} Tables  what Python sends
 * @property {Uint32Array} faceAtom
 * @property {Uint32Array} atomSegment
 * @property {Uint32Array | null} atomPart  levels one after another
 * @property {Uint8Array | null} segmentColors
 * @property {Uint16Array | null} [atomConfidence]
 */

/**
 * The surface: of a mesh, or of a cloud, whose faces are its points and which says their areas.
 * @typedef {{ vertices: Float32Array, faces: Uint32Array, areas?: Float32Array | null }} Measured
 */

/**
 * @param {Tables} arrays
 * @param {number} level  index of the level; -1 = the segments as they are
 * @param {Measured | null} [mesh]  to measure areas on
 * @returns {Partition}
 */
export function makePartition(arrays, level, mesh = null) {
  const { faceAtom, atomSegment, atomPart, segmentColors, atomConfidence = null } = arrays;
  const nAtoms = atomSegment.length;
  const isThere = atomPart !== null && level >= 0 && atomPart.length >= (level + 1) * nAtoms;
  return {
    faceAtom,
    atomSegment,
    atomPart: isThere ? atomPart.subarray(level * nAtoms, (level + 1) * nAtoms) : atomSegment,
    ...measure(faceAtom, nAtoms, mesh),
    segmentColors: segmentColors ?? new Uint8Array(0),
    atomConfidence: atomConfidence?.length === nAtoms ? atomConfidence : null,
  };
}

/** @type {WeakMap<Uint32Array, { atomFaces: Uint32Array, atomArea: Float64Array }>} */
const measures = new WeakMap();

/**
 * Faces and area of each atom.
 * @param {Uint32Array} faceAtom
 * @param {number} nAtoms
 * @param {Measured | null} mesh
 */
function measure(faceAtom, nAtoms, mesh) {
  const known = measures.get(faceAtom);
  if (known?.atomFaces.length === nAtoms) return known;
  const [atomFaces, atomArea] = [new Uint32Array(nAtoms), new Float64Array(nAtoms)];
  for (let face = 0; face < faceAtom.length; face++) {
    atomFaces[faceAtom[face]]++;
    if (mesh) atomArea[faceAtom[face]] += areaOf(mesh, face);
  }
  measures.set(faceAtom, { atomFaces, atomArea });
  return { atomFaces, atomArea };
}

/**
 * Measures of atoms of which some were divided, without looking at every face: areas go by the number of faces.
 * @param {Uint32Array} faceAtom  before
 * @param {Uint32Array} finer  after
 * @param {Array<[atom: number, n: number]>} taken  atoms that were divided, and the faces of each new one
 */
export function divideMeasures(faceAtom, finer, taken) {
  const known = measures.get(faceAtom);
  if (!known) return;
  const n = known.atomFaces.length;
  const [atomFaces, atomArea] = [new Uint32Array(n + taken.length), new Float64Array(n + taken.length)];
  atomFaces.set(known.atomFaces);
  atomArea.set(known.atomArea);
  taken.forEach(([atom, count], i) => {
    const area = (known.atomArea[atom] * count) / known.atomFaces[atom];
    [atomFaces[n + i], atomArea[n + i]] = [count, area];
    atomFaces[atom] -= count;
    atomArea[atom] -= area;
  });
  measures.set(finer, { atomFaces, atomArea });
}

/**
 * @param {Measured} mesh
 * @param {number} face
 */
function areaOf({ vertices, faces, areas }, face) {
  if (areas) return areas[face];
  const [a, b, c] = [3 * faces[3 * face], 3 * faces[3 * face + 1], 3 * faces[3 * face + 2]];
  const ux = vertices[b] - vertices[a];
  const uy = vertices[b + 1] - vertices[a + 1];
  const uz = vertices[b + 2] - vertices[a + 2];
  const vx = vertices[c] - vertices[a];
  const vy = vertices[c + 1] - vertices[a + 1];
  const vz = vertices[c + 2] - vertices[a + 2];
  return 0.5 * Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
}

/**
 * The part and the segment of a face, and their sizes.
 * @param {Partition} partition
 * @param {number} face
 */
export function describe({ faceAtom, atomPart, atomSegment, atomFaces, atomArea }, face) {
  const atom = faceAtom[face];
  const [part, segment] = [atomPart[atom], atomSegment[atom]];
  let [partFaces, segmentFaces, segmentArea] = [0, 0, 0];
  for (let i = 0; i < atomFaces.length; i++) {
    if (atomPart[i] === part) partFaces += atomFaces[i];
    if (atomSegment[i] === segment) {
      segmentFaces += atomFaces[i];
      segmentArea += atomArea[i];
    }
  }
  return { part, segment, partFaces, segmentFaces, segmentArea };
}

/**
 * How many segments there are.
 * @param {Uint32Array} atomSegment
 */
export function countSegments(atomSegment) {
  const seen = new Set(atomSegment);
  seen.delete(NONE);
  return seen.size;
}
