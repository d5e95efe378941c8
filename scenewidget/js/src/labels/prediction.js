/**
 * Edits as the browser foresees them: shown at once, until Python's own answer comes.
 *
 * Goes in: what Python sent last, and the edits that it hasn't answered yet. Comes out: the segments to show.
 * The rules are those of `scenewidget.editing.partition`; where they should ever differ, Python's answer wins.
 */

import { painted } from "./painting.js";
import { NONE } from "./partition.js";

/**
 * @typedef {{ kind: "merge", face: number | number[], onto_face: number, level: string }
 *   | { kind: "split", face: number, level: string }
 *   | { kind: "cut", face_a: number, face_b: number }
 *   | { kind: "paint", ranges: number[], onto_face: number | null, draft?: import("./painting.js").Draft }
 *   | { kind: "slice", face: number, point: number[], normal: number[], off?: number[] }
 *   | { kind: Refinement, face: number }
 *   | { kind: "group", face: number | number[], onto_face: number | null }
 *   | { kind: "relabel", face: number, name: string }} Edit
 */

/** @typedef {"grow" | "shrink" | "fill_holes" | "smooth_border"} Refinement  Python alone knows what becomes of it */
/** @typedef {Edit | { kind: "undo" | "redo" } | { kind: "go_to", n: number }} Operation */

/**
 * @typedef {object} Ground  what edits don't change
 * @property {Uint32Array} faceAtom
 * @property {Record<string, Uint32Array>} parts  of each atom, by level
 */

/**
 * @typedef {object} Labels
 * @property {Uint32Array} atomSegment
 * @property {Record<string, string>} names
 * @property {import("./painting.js").FinerGround} [finer]  the ground, where painting has divided atoms
 */

/** The level whose parts, to a merge, are the segments as they are now. */
export const FINAL = "final";

const TITLES = {
  ...{ merge: "Merge", split: "Split", relabel: "Name", cut: "Cut", paint: "Paint", slice: "Slice" },
  group: "Group",
  ...{ grow: "Grow", shrink: "Shrink", fill_holes: "Fill holes", smooth_border: "Smooth border" },
};
const REFINEMENTS = ["grow", "shrink", "fill_holes", "smooth_border"];

/**
 * The labels after an edit, or why it can't be done.
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Edit} edit
 * @returns {Labels | string}
 */
export function foresee(ground, labels, edit) {
  ground = labels.finer ?? ground;
  if (edit.kind === "paint") return afterPaint(ground, labels, edit);
  if (edit.kind === "cut") return beforeCut(ground, labels, edit);
  if (edit.kind === "slice") {
    const paint = /** @type {const} */ ({ kind: "paint", ranges: edit.off ?? [], onto_face: null });
    return edit.off ? afterPaint(ground, labels, paint) : { ...labels };
  }
  const first = Array.isArray(edit.face) ? edit.face[0] : edit.face;
  const home = labels.atomSegment[ground.faceAtom[first]];
  if (edit.kind === "group" || isRefinement(edit))
    return home === NONE ? "This surface is unlabeled: there is no segment here" : { ...labels };
  if (edit.kind === "relabel") {
    if (home === NONE) return "This surface is unlabeled: there is no segment to name";
    if ((labels.names[home] ?? "") === edit.name) return "The segment has this name already";
    const { [home]: _, ...names } = labels.names;
    return { ...labels, names: edit.name ? { ...names, [home]: edit.name } : names };
  }
  const moves = movedAtoms(ground, labels, edit);
  if (!moves) return "This surface belongs to no part of this level";
  if (edit.kind === "split") {
    const isWhole = labels.atomSegment.every((segment, atom) => (segment === home) === moves(atom));
    if (home !== NONE && isWhole) return "This is a segment of its own already; a finer level can divide it";
    return moved(labels, moves, highest(labels.atomSegment) + 1);
  }
  const target = labels.atomSegment[ground.faceAtom[edit.onto_face]];
  if (target === NONE) return "That surface is unlabeled: there is no segment to join";
  return joins(labels, moves, target) ? moved(labels, moves, target) : "Both are in one segment already";
}

/** @param {Edit} edit @returns {edit is { kind: Refinement, face: number }} */
function isRefinement(edit) {
  return REFINEMENTS.includes(edit.kind);
}

/**
 * Whether a merge would move anything; cheap enough to ask while the pointer moves.
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Extract<Edit, { kind: "merge" }>} edit
 */
export function canMerge(ground, labels, edit) {
  ground = labels.finer ?? ground;
  const moves = movedAtoms(ground, labels, edit);
  const target = labels.atomSegment[ground.faceAtom[edit.onto_face]];
  return moves !== null && target !== NONE && joins(labels, moves, target);
}

/**
 * Python alone knows where a cut goes: until it answers, everything stays as it is.
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Extract<Edit, { kind: "cut" }>} edit
 * @returns {Labels | string}
 */
function beforeCut({ faceAtom }, labels, { face_a, face_b }) {
  const [a, b] = [labels.atomSegment[faceAtom[face_a]], labels.atomSegment[faceAtom[face_b]]];
  if (a === NONE || b === NONE) return "This surface is unlabeled: there is no segment to cut";
  return a === b ? { ...labels } : "A cut needs two points of the same segment";
}

/**
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Extract<Edit, { kind: "paint" }>} edit
 * @returns {Labels | string}
 */
function afterPaint(ground, labels, { ranges, onto_face, draft }) {
  const target =
    onto_face === null ? highest(labels.atomSegment) + 1 : labels.atomSegment[ground.faceAtom[onto_face]];
  if (target === NONE) return "That surface is unlabeled: there is no segment to paint onto";
  const after = painted(ground, labels.atomSegment, ranges, target, draft);
  if (!after) return "All of that is in this segment already";
  return { ...withNames(labels.names, after.atomSegment, target), finer: after.ground };
}

/** @param {Labels} labels @param {(atom: number) => boolean} moves @param {number} target */
function joins({ atomSegment }, moves, target) {
  return atomSegment.some((segment, atom) => segment !== target && moves(atom));
}

/**
 * The labels after several operations, each as far as it can be foreseen, and what can be undone then:
 * undefined = whatever Python could undo before them, "" = something that isn't known by name.
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Operation[]} operations
 * @returns {{ labels: Labels, undo: string | undefined, redo: string | undefined }}
 */
export function replay(ground, labels, operations) {
  const done = [{ labels, title: "" }];
  /** @type {typeof done} */
  const undone = [];
  let [depth, isFork] = [0, false]; // how far below `labels` undo has gone
  for (const operation of operations) {
    if (operation.kind === "undo") {
      const step = done.length > 1 ? done.pop() : undefined;
      if (step) undone.push(step);
      else depth++;
    } else if (operation.kind === "redo") {
      const step = undone.pop();
      if (step) done.push(step);
      else depth = Math.max(0, depth - 1);
    } else if (operation.kind !== "go_to") {
      const next = foresee(ground, done[done.length - 1].labels, /** @type {Edit} */ (operation));
      if (typeof next === "string") continue;
      done.push({ labels: next, title: titleOf(/** @type {Edit} */ (operation)) });
      undone.length = 0;
      isFork = true;
    }
  }
  const last = done[done.length - 1];
  const canRedo = undone[undone.length - 1]?.title ?? (depth > 0 ? "" : undefined);
  return {
    labels: last.labels,
    undo: done.length > 1 ? last.title : depth > 0 ? "" : undefined,
    redo: isFork && undone.length === 0 ? NOTHING : canRedo,
  };
}

/** @param {Edit} edit */
function titleOf(edit) {
  const n = edit.kind === "merge" && Array.isArray(edit.face) ? edit.face.length : 1;
  return n > 1 ? `Merge ${n} parts` : TITLES[edit.kind];
}

/** Said of redo after a new edit: there is nothing to redo any more. */
export const NOTHING = "\0";

/**
 * Whether an atom would be moved by an edit; null if the face belongs to no part.
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {Extract<Edit, { kind: "merge" | "split" }>} edit
 * @returns {((atom: number) => boolean) | null}
 */
function movedAtoms(ground, labels, edit) {
  if (!Array.isArray(edit.face)) return movedByOne(ground, labels, { ...edit, face: edit.face });
  const column = edit.level === FINAL ? labels.atomSegment : ground.parts[edit.level];
  const moved = new Set(edit.face.map((face) => column?.[ground.faceAtom[face]] ?? NONE));
  moved.delete(NONE); // those that belong to no part are passed over
  return moved.size === 0 ? null : (i) => moved.has(column[i]);
}

/**
 * @param {Ground} ground
 * @param {Labels} labels
 * @param {{ kind: "merge" | "split", face: number, level: string }} edit
 * @returns {((atom: number) => boolean) | null}
 */
function movedByOne({ faceAtom, parts }, { atomSegment }, { kind, face, level }) {
  const atom = faceAtom[face];
  const atomPart = parts[level];
  const [part, home] = [atomPart?.[atom] ?? NONE, atomSegment[atom]];
  if (level !== FINAL) return part === NONE ? null : (i) => atomPart[i] === part;
  if (home === NONE) return null;
  if (kind === "merge" || !atomPart) return (i) => atomSegment[i] === home;
  return (i) => atomSegment[i] === home && atomPart[i] === part;
}

/**
 * Atoms put into a segment; a name isn't lost with the last atom of the segment that had it.
 * @param {Labels} labels
 * @param {(atom: number) => boolean} moves
 * @param {number} target
 * @returns {Labels}
 */
function moved({ atomSegment, names, finer }, moves, target) {
  const after = atomSegment.map((segment, atom) => (moves(atom) ? target : segment));
  return { ...withNames(names, after, target), ...(finer && { finer }) };
}

/**
 * @param {Record<string, string>} names  before
 * @param {Uint32Array} after  segments of the atoms
 * @param {number} target  that has taken some
 */
function withNames(names, after, target) {
  const living = new Set(after);
  const gone = Object.keys(names).filter((segment) => !living.has(Number(segment)));
  const kept = Object.fromEntries(Object.entries(names).filter(([segment]) => living.has(Number(segment))));
  if (!(target in kept) && gone.length > 0) kept[target] = names[gone[0]];
  return { atomSegment: after, names: kept };
}

/** Highest number of a segment, -1 if there is none. @param {Uint32Array} atomSegment */
export function highest(atomSegment) {
  let most = -1;
  for (const segment of atomSegment) if (segment !== NONE && segment > most) most = segment;
  return most;
}
