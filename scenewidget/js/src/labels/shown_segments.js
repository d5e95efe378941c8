/** The segments as one page shows them: Python's, with the edits on top that it hasn't answered yet. */

import { nounOf } from "../wire/traits.js";
import { readArray } from "../wire/wire.js";
import { meanConfidence } from "./confidence.js";
import { describeFace, segmentTitle } from "./description.js";
import { divided } from "./offcut.js";
import { finerTables } from "./painting.js";
import { countSegments, makePartition, NONE } from "./partition.js";
import { pendingOf } from "./pending.js";
import { canMerge, FINAL, foresee, highest, NOTHING, replay } from "./prediction.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {import("./partition.js").Partition} Partition */
/** @typedef {import("./partition.js").Tables} Tables */
/** @typedef {{ left: number, top: number, right: number, bottom: number }} Area  of the picture, CSS pixels from the upper left */

/**
 * What shows them.
 * @typedef {object} Picture
 * @property {{ vertices: Float32Array, faces: Uint32Array } | null} mesh
 * @property {(partition: Partition | null, area?: Area | null) => void} setPartition  area: all that has changed
 */

export class ShownSegments {
  /**
   * @param {Model} model
   * @param {import("./preview.js").Preview} preview
   * @param {Picture} picture
   */
  constructor(model, preview, picture) {
    this.model = model;
    this.preview = preview;
    this.picture = picture;
    /** What the picture shows. @type {Partition | null} */
    this.partition = null;
    this.pending = pendingOf(model.get("_token") ?? "");
    /** @type {import("./prediction.js").Ground | null} */
    this.ground = null;
    /** @type {ReturnType<typeof replay> | null} */
    this.shown = null;
    /** An edit that is being made: shown, but not told. @type {import("./prediction.js").Edit | null} */
    this.sketch = null;
    /** Where alone the sketch has changed since it was last shown, if that is known. @type {Area | null} */
    this.sketchArea = null;
    /** The segments without a stroke that is being painted. @type {{ faceAtom: Uint32Array, atomSegment: Uint32Array } | null} */
    this.base = null;
    /** What a cut would divide off, shown as if it were done, while `under` are the segments. @type {{ under: Uint32Array, segment: number, nFaces: number, tables: Tables } | null} */
    this.offcut = null;
    /** A face of each part that a suggested edit moves: they count as one part. @type {number[]} */
    this.suggested = [];
    /** Whether something else is shown for the moment. */
    this.isPreview = false;
    /** @type {Tables | null} */
    this.tables = null;
  }

  /** What faces are called: of a cloud they are points. */
  get noun() {
    return nounOf(this.model);
  }

  /** Take what the model holds and show it. */
  read() {
    const { model, picture } = this;
    const faceAtom = /** @type {Uint32Array | null} */ (readArray(model, "face_atom"));
    const atomSegment = /** @type {Uint32Array | null} */ (readArray(model, "atom_segment"));
    if (!faceAtom || !atomSegment) {
      this.ground = this.shown = this.offcut = null;
      this.#show(null);
      return;
    }
    const atomPart = /** @type {Uint32Array | null} */ (readArray(model, "atom_part"));
    const segmentColors = /** @type {Uint8Array | null} */ (readArray(model, "segment_colors"));
    const atomConfidence = /** @type {Uint16Array | null} */ (readArray(model, "atom_confidence"));
    this.pending.answered(model.get("_answers"));
    this.ground = { faceAtom, parts: partsOf(model.get("levels"), atomPart, atomSegment.length) };
    const labels = { atomSegment, names: model.get("segment_names") };
    const operations = this.sketch ? [...this.pending.operations, this.sketch] : this.pending.operations;
    this.shown = replay(this.ground, labels, operations);
    if (this.sketch?.kind !== "paint")
      this.base = { faceAtom: (this.shown.labels.finer ?? this.ground).faceAtom, ...this.shown.labels };
    const { finer } = this.shown.labels;
    this.ground = finer ?? this.ground;
    const preview = this.preview.tables();
    this.isPreview = preview !== null;
    if (preview) {
      this.#show(makePartition({ ...preview, atomPart: null }, -1, picture.mesh));
      return;
    }
    const level = this.level === FINAL ? -1 : model.get("levels").indexOf(this.level);
    const { atomSegment: under } = this.shown.labels;
    const tables = { faceAtom, atomSegment: under, atomPart, segmentColors, atomConfidence };
    this.tables = finer ? finerTables(tables, finer, model.get("levels")) : tables;
    if (this.offcut?.under !== under) this.offcut = null;
    const [shown, row] = gathered(this.offcut?.tables ?? this.tables, level, this.suggested);
    this.#show(makePartition(shown, row, picture.mesh));
  }

  /** @param {Partition | null} partition */
  #show(partition) {
    this.partition = partition;
    this.picture.setPartition(partition, this.sketchArea);
    this.sketchArea = null;
  }

  /** Show some faces as a segment of their own until the segments change; none ends it. @param {number[]} faces */
  cutOff(faces) {
    const under = this.atomSegment;
    const segment = under ? highest(under) + 1 : 0;
    this.offcut =
      under && this.tables && faces.length > 0
        ? { under, segment, nFaces: faces.length, tables: divided(this.tables, faces, segment) }
        : null;
  }

  /** Segments of the atoms as they are shown, but for an offcut. */
  get atomSegment() {
    return this.shown?.labels.atomSegment ?? null;
  }

  /** Segment under a face, whatever a cut would divide off. @param {number} face */
  segmentOf(face) {
    const { ground, atomSegment, offcut } = this;
    return offcut && ground && atomSegment ? atomSegment[ground.faceAtom[face]] : this.#shownSegmentOf(face);
  }

  /** Segment under a face, whatever the stroke that is being painted. @param {number} face */
  baseOf(face) {
    return this.base ? this.base.atomSegment[this.base.faceAtom[face]] : NONE;
  }

  /** @param {number} face */
  #shownSegmentOf(face) {
    return this.partition ? this.partition.atomSegment[this.partition.faceAtom[face]] : NONE;
  }

  /** Whether two faces are in one segment. @param {number} first @param {number} second */
  canCut(first, second) {
    const edit = /** @type {const} */ ({ kind: "cut", face_a: first, face_b: second });
    const labels = this.shown?.labels;
    return (
      !this.isPreview &&
      !!this.ground &&
      !!labels &&
      first !== second &&
      typeof foresee(this.ground, labels, edit) !== "string"
    );
  }

  get level() {
    return this.model.get("level");
  }

  get count() {
    const shown = this.isPreview ? this.partition?.atomSegment : this.atomSegment;
    return shown ? countSegments(shown) : 0;
  }

  /** Names by segment. @returns {Record<string, string>} */
  get names() {
    return this.isPreview ? {} : (this.shown?.labels.names ?? {});
  }

  /** What a segment is a part of; those of nothing aren't there. @returns {Record<string, number>} */
  get groups() {
    return this.isPreview ? {} : (this.model.get("segment_groups") ?? {});
  }

  /** Name of the step that undo would take; null = there is none. @returns {string | null} */
  get undo() {
    return this.shown?.undo ?? (this.model.get("undo_title") || null);
  }

  /** @returns {string | null} */
  get redo() {
    if (this.shown?.redo === NOTHING) return null;
    return this.shown?.redo ?? (this.model.get("redo_title") || null);
  }

  /** Whether the part under a face can be merged with what is under another. @param {number} face @param {number} onto */
  isTarget(face, onto) {
    const edit = /** @type {const} */ ({ kind: "merge", face, onto_face: onto, level: this.level });
    return this.ground !== null && this.shown !== null && canMerge(this.ground, this.shown.labels, edit);
  }

  /** Of each segment. While edits wait for Python, its numbers are of other segments. */
  get confidence() {
    if (this.isPreview) return null;
    const isSettled = this.pending.operations.length === 0;
    if (isSettled) return /** @type {Float32Array | null} */ (readArray(this.model, "segment_confidence"));
    return this.partition && meanConfidence(this.partition);
  }

  /** What the status line says of a face. @param {number} face */
  descriptionOf(face) {
    const partition = /** @type {import("./partition.js").Partition} */ (this.partition);
    const segment = this.#shownSegmentOf(face);
    const { level, names, confidence, noun } = this;
    const context = { level, names, confidence, noun };
    const [red, green, blue] = partition.segmentColors.subarray(3 * segment, 3 * segment + 3);
    return {
      text: describeFace(partition, face, context),
      color: segment === NONE || blue === undefined ? null : `rgb(${red} ${green} ${blue})`,
    };
  }

  /** @param {import("./partition.js").Hit} hit */
  titleOf({ part, segment }) {
    return part === segment ? segmentTitle(segment, this.names) : `Part of level ${this.level}`;
  }
}

/**
 * Parts of each atom by level.
 * @param {string[]} levels
 * @param {Uint32Array | null} atomPart  levels one after another
 * @param {number} nAtoms
 */
function partsOf(levels, atomPart, nAtoms) {
  const rows = levels.map((_, i) => atomPart?.subarray(i * nAtoms, (i + 1) * nAtoms) ?? new Uint32Array(0));
  return Object.fromEntries(levels.map((level, i) => [level, rows[i]]));
}

/**
 * Tables in which several parts are one, and the row of their parts; −1: the segments.
 * @param {Tables} tables
 * @param {number} level
 * @param {number[]} faces  one of each
 * @returns {[Tables, number]}
 */
function gathered(tables, level, faces) {
  if (faces.length < 2) return [tables, level];
  const { faceAtom, atomSegment, atomPart } = tables;
  const n = atomSegment.length;
  const column = level < 0 || !atomPart ? atomSegment : atomPart.subarray(level * n, (level + 1) * n);
  const parts = new Set(faces.map((face) => column[faceAtom[face]]));
  const first = column[faceAtom[faces[0]]];
  return [{ ...tables, atomPart: column.map((part) => (parts.has(part) ? first : part)) }, 0];
}
