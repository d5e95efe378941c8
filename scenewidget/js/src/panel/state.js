/** What the page around a picture shows, gathered from the model and the view. */

import { FIRST_STEPS, FIRST_TOUCHES } from "../input/keys.js";
import { summary } from "../labels/description.js";
import { countHidden } from "../labels/hidden.js";
import { nounOf } from "../wire/traits.js";
import { readArray } from "../wire/wire.js";
import { legendOf } from "./legend.js";

/**
 * @typedef {object} PanelState
 * @property {string} colorBy
 * @property {string} [errorsTitle]  what errors are shown against; "" = none can be shown
 * @property {boolean} hasScan
 * @property {boolean} [offersBorders]  whether doubtful borders can be shown
 * @property {string[]} [columns]  of the table of segments, that can be shown
 * @property {string} [column]  the one that is; "" = none
 * @property {boolean} [boxes]  whether they are drawn
 * @property {boolean} hasValues
 * @property {string} valuesTitle
 * @property {boolean} hasPartition
 * @property {boolean} hasConfidence
 * @property {string[]} levels
 * @property {string} level
 * @property {boolean} outlines
 * @property {boolean} backFaces
 * @property {boolean} segmentList  whether it is open
 * @property {import("../scene/section.js").Range[]} section
 * @property {number[]} lengths  of the scan, that the section is part of
 * @property {number} mixing
 * @property {boolean} busy
 * @property {number} progress
 * @property {string} status
 * @property {string} error
 * @property {"navigate" | "edit"} mode
 * @property {boolean} editable  whether it offers to edit
 * @property {string | null} undo  name of the step; "" = a step without a name, null = none
 * @property {string | null} redo
 * @property {number} pending  edits that Python hasn't answered
 * @property {import("./autosave.js").SaveState} saveState
 * @property {string} saveNote
 * @property {import("./notices.js").Notice[]} notices
 * @property {string} noun  what faces are called
 * @property {number} nSegments
 * @property {number} nHidden  segments that aren't drawn
 * @property {string[]} vocabulary
 * @property {string[]} quickNames
 * @property {boolean} historyShown
 * @property {import("./history.js").Step[]} history
 * @property {number} nDone  edits that are done
 * @property {string} summary  shown at rest, with the status
 * @property {import("./legend.js").Legend | null} legend  of the colours shown
 */

const firstSteps = globalThis.matchMedia?.("(pointer: coarse)").matches ? FIRST_TOUCHES : FIRST_STEPS;

/**
 * @param {Pick<import("../input/messages.js").Around, "model" | "view" | "segments">} around
 * @param {object} more
 * @param {import("../input/gestures.js").Tool} more.tool
 * @param {boolean} more.isLive
 * @param {import("./notices.js").Notice[]} more.notices  before those of the model
 * @returns {PanelState}
 */
export function panelState({ model, view, segments }, { tool, isLive, notices }) {
  const { mesh, partition } = view;
  const isUntouched = !segments.undo && !segments.redo;
  const isBusy = model.get("busy") && isLive;
  const wasBusy = model.get("busy") && !isLive; // what it said of a computation that nobody does any more
  const isFirstStep = model.get("mode") === "edit" && tool === "merge" && isUntouched;
  return {
    colorBy: model.get("color_by"),
    hasScan: mesh?.colors != null,
    errorsTitle: model.get("errors_title"),
    offersBorders: model.get("offers_borders"),
    columns: model.get("columns"),
    column: model.get("column"),
    boxes: model.get("boxes"),
    hasValues: readArray(model, "face_value") !== null,
    valuesTitle: model.get("values_legend").title ?? "",
    hasPartition: partition !== null,
    hasConfidence: partition?.atomConfidence != null,
    levels: model.get("levels"),
    level: model.get("level"),
    outlines: model.get("outlines"),
    backFaces: model.get("back_faces"),
    segmentList: model.get("segment_list"),
    section: model.get("section"),
    lengths: view.lengths,
    mixing: model.get("color_mix"),
    busy: isBusy,
    progress: model.get("progress"),
    status: (isFirstStep && !isBusy) || wasBusy ? "" : model.get("status"),
    error: model.get("error"),
    mode: model.get("mode"),
    editable: model.get("editable") && isLive,
    undo: segments.undo,
    redo: segments.redo,
    pending: segments.pending.operations.length,
    noun: nounOf(model),
    nSegments: segments.count,
    nHidden: countHidden(view.hidden, partition),
    vocabulary: model.get("vocabulary"),
    saveState: model.get("save_state"),
    saveNote: model.get("save_note"),
    notices: [...notices, ...(isLive ? model.get("notices") : [])], // Python would have to answer
    quickNames: model.get("quick_names"),
    historyShown: model.get("history_shown"),
    history: model.get("history"),
    nDone: model.get("n_done"),
    summary: isFirstStep ? firstSteps : mesh ? summary(mesh.faces.length / 3, partition, nounOf(model)) : "",
    legend: legendOf(model),
  };
}
