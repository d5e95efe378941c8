/**
 * What painting does to the tables: atoms that a stroke divides become finer, as in Python's `Partition`.
 *
 * Faces of a stroke come as ranges, as Python keeps them: the first face and the one after the last of each run.
 */

import { divideMeasures, NONE } from "./partition.js";

/**
 * @typedef {object} FinerGround
 * @property {Uint32Array} faceAtom
 * @property {Record<string, Uint32Array>} parts  of each atom, by level
 * @property {Uint32Array} parents  the atom of Python's that each one is a part of
 */

/**
 * Ranges of some faces.
 * @param {Iterable<number>} faces
 * @returns {number[]}
 */
export function rangesOf(faces) {
  const sorted = Uint32Array.from(faces).sort();
  /** @type {number[]} */
  const ranges = [];
  for (const face of sorted) {
    if (ranges.length > 0 && face <= ranges[ranges.length - 1]) ranges[ranges.length - 1] = face + 1;
    else ranges.push(face, face + 1);
  }
  return ranges;
}

/** @param {number[]} ranges @returns {Generator<number>} */
export function* facesIn(ranges) {
  for (let i = 0; i < ranges.length; i += 2)
    for (let face = ranges[i]; face < ranges[i + 1]; face++) yield face;
}

/** @type {WeakMap<Uint32Array, Uint32Array>} */
const sizes = new WeakMap();

/**
 * What a table of faces was made from, and which faces have another atom there.
 * @type {WeakMap<Uint32Array, { of: Uint32Array, ranges: number[], touched: number[] }>}
 */
const origins = new WeakMap();

/** The table that some faces were painted on, as long as they are kept. @type {WeakMap<number[], Uint32Array>} */
const done = new WeakMap();

/**
 * The table of faces that a stroke is shown with: one for all of its frames, changed where the stroke has.
 * @typedef {{ faceAtom: Uint32Array | null }} Draft
 */

/**
 * Ranges of the faces in which two tables may differ; null if that isn't known.
 * @param {Uint32Array} before
 * @param {Uint32Array} after  may be the same, changed by a draft since it was shown
 * @returns {number[] | null}
 */
export function differences(before, after) {
  const [old, next] = [origins.get(before), origins.get(after)];
  if (before === after) return next?.touched ?? [];
  if (next?.of === before) return next.ranges;
  if (old?.of === after) return old.ranges;
  return old && next && old.of === next.of ? [...old.ranges, ...next.ranges] : null;
}

/**
 * A copy of a table of faces in which some are about to change; of a draft it is the one of the last frame, as new.
 * @param {Uint32Array} faceAtom
 * @param {number[]} ranges
 * @param {Draft | undefined} draft
 */
function copied(faceAtom, ranges, draft) {
  const used = draft ? draft.faceAtom : (done.get(ranges) ?? null);
  const origin = used && origins.get(used);
  if (!used || origin?.of !== faceAtom) {
    const copy = faceAtom.slice();
    origins.set(copy, { of: faceAtom, ranges, touched: ranges });
    if (draft) draft.faceAtom = copy;
    else done.set(ranges, copy);
    return copy;
  }
  for (const face of facesIn(origin.ranges)) used[face] = faceAtom[face];
  origins.set(used, { of: faceAtom, ranges, touched: [...origin.ranges, ...ranges] });
  return used;
}

/**
 * Faces put into a segment; null if all of them are in it already.
 * @param {Omit<FinerGround, "parents"> & { parents?: Uint32Array }} ground
 * @param {Uint32Array} atomSegment
 * @param {number[]} ranges
 * @param {number} target
 * @param {Draft} [draft]  of a stroke that goes on
 * @returns {{ ground: FinerGround, atomSegment: Uint32Array } | null}
 */
export function painted(ground, atomSegment, ranges, target, draft) {
  const { faceAtom, parts } = ground;
  const nBefore = atomSegment.length;
  /** How many faces of each atom are painted. @type {Map<number, number>} */
  const counts = new Map();
  for (const face of facesIn(ranges)) {
    const atom = faceAtom[face];
    if (atomSegment[atom] !== target) counts.set(atom, (counts.get(atom) ?? 0) + 1);
  }
  if (counts.size === 0) return null;
  const whole = sizesOf(faceAtom, nBefore);
  const divided = [...counts].filter(([atom, n]) => n < whole[atom]).map(([atom]) => atom);
  const twins = new Map(divided.map((atom, i) => [atom, nBefore + i]));
  const finer = divided.length > 0 ? copied(faceAtom, ranges, draft) : faceAtom;
  for (const face of divided.length > 0 ? facesIn(ranges) : [])
    finer[face] = twins.get(finer[face]) ?? finer[face];
  if (divided.length > 0)
    divideMeasures(
      faceAtom,
      finer,
      divided.map((atom) => [atom, counts.get(atom) ?? 0]),
    );
  const grown = (/** @type {Uint32Array} */ row) => extended(row, divided);
  const after = grown(atomSegment);
  for (const atom of counts.keys()) after[twins.get(atom) ?? atom] = target;
  return {
    ground: {
      faceAtom: finer,
      parts: Object.fromEntries(Object.entries(parts).map(([level, row]) => [level, grown(row)])),
      parents: grown(ground.parents ?? Uint32Array.from({ length: nBefore }, (_, atom) => atom)),
    },
    atomSegment: after,
  };
}

/**
 * Python's tables as finer atoms have them.
 * @param {import("./partition.js").Tables} tables
 * @param {FinerGround} ground
 * @param {string[]} levels
 * @returns {import("./partition.js").Tables}
 */
export function finerTables(tables, { faceAtom, parts, parents }, levels) {
  const { atomPart, atomConfidence } = tables;
  return {
    ...tables,
    faceAtom,
    atomPart: atomPart && joined(levels.map((level) => parts[level])),
    atomConfidence: atomConfidence ? Uint16Array.from(parents, (atom) => atomConfidence[atom]) : null,
  };
}

/** @param {Uint32Array} row @param {number[]} atoms  that get a twin each */
function extended(row, atoms) {
  if (row.length === 0) return row;
  const next = new Uint32Array(row.length + atoms.length);
  next.set(row);
  atoms.forEach((atom, i) => {
    next[row.length + i] = row[atom] ?? NONE;
  });
  return next;
}

/** @param {Uint32Array[]} rows */
function joined(rows) {
  const all = new Uint32Array(rows.reduce((n, row) => n + row.length, 0));
  let end = 0;
  for (const row of rows) {
    all.set(row, end);
    end += row.length;
  }
  return all;
}

/** How many faces each atom has. @param {Uint32Array} faceAtom @param {number} nAtoms */
function sizesOf(faceAtom, nAtoms) {
  let size = sizes.get(faceAtom);
  if (size?.length !== nAtoms) {
    size = new Uint32Array(nAtoms);
    for (const atom of faceAtom) size[atom]++;
    sizes.set(faceAtom, size);
  }
  return size;
}
