/** What people do to segments: edits go to Python and show at once; hiding and framing stay on the page. */

import { segmentTitle } from "../labels/description.js";
import { NONE } from "../labels/partition.js";
import { foresee } from "../labels/prediction.js";

/** @typedef {import("./gestures.js").Place} Place */

const PREVIEW = "This is a preview: let go of the slider, and edit the result";

/**
 * @param {object} around
 * @param {import("../wire/wire.js").Model} around.model
 * @param {import("../scene/viewer.js").Viewer} around.view
 * @param {ReturnType<typeof import("../panel/panel.js").createPanel>} around.panel
 * @param {import("../labels/shown_segments.js").Labelling} around.labelling
 * @param {object} callbacks
 * @param {() => void} callbacks.onEdit  segments have changed
 * @param {() => void} callbacks.onHide  what is drawn has changed
 * @param {() => void} callbacks.letGo  of the picked part
 */
export function createEditing({ model, view, panel, labelling }, { onEdit, onHide, letGo }) {
  /** Show an edit and tell Python of it, unless it makes no sense. @param {import("../labels/prediction.js").Edit} operation */
  function edit(operation) {
    if (panel.root.dataset.live === "false") return;
    if (labelling.isPreview) {
      panel.remark(PREVIEW);
      return;
    }
    const { ground, shown } = labelling;
    const revision = model.get("revision");
    if (!model.get("editable") || !ground || !shown) {
      model.send({ ...operation, revision });
      return;
    }
    const foreseen = foresee(ground, shown.labels, operation);
    if (typeof foreseen === "string") panel.remark(foreseen);
    else queue(operation, { revision });
  }

  /** Undo or redo. @param {"undo" | "redo"} kind */
  function walk(kind) {
    if (panel.root.dataset.live === "false") return;
    if (labelling.isPreview) {
      panel.remark(PREVIEW);
      return;
    }
    if (kind === "undo" && labelling.sketch) {
      letGo(); // what the brush has gathered shows as the last step
      return;
    }
    if (!model.get("editable")) model.send({ kind });
    else queue({ kind }, {});
  }

  /** Undo or redo until so many edits are done. @param {number} n */
  function goTo(n) {
    if (labelling.isPreview) panel.remark(PREVIEW);
    else queue({ kind: "go_to", n }, {});
  }

  /** Give the segment under a face one of the names that have keys. @param {number} face @param {string} given */
  function nameQuickly(face, given) {
    const segment = view.segmentOf(face);
    if (segment === NONE) panel.remark("This surface is unlabelled: there is no segment to name");
    else edit({ kind: "relabel", face, name: given });
  }

  /** @param {import("../labels/prediction.js").Operation} operation @param {object} details */
  function queue(operation, details) {
    panel.remark("");
    const answer = labelling.pending.add(operation);
    try {
      model.send({ ...operation, ...details, ...answer });
    } catch {
      labelling.pending.forget();
      panel.remark("The kernel is gone: nothing was edited. Run the cell again");
    }
    onEdit();
  }

  /** @param {import("./keys.js").PartAction} what @param {number} face @param {Place | null} place */
  function act(what, face, place) {
    switch (what) {
      case "split":
        letGo();
        edit({ kind: "split", face, level: labelling.level });
        break;
      case "name":
        name(face, place ?? { x: view.size.width / 2, y: view.size.height / 2 });
        break;
      case "frame":
        view.lookAt(face);
        break;
      default:
        hide(face, what === "isolate");
    }
  }

  /** @param {number} face @param {Place} place */
  function name(face, place) {
    if (!model.get("editable") && model.get("mode") !== "edit") return; // nobody would take it
    const segment = labelling.segmentOf(face);
    const { names } = labelling;
    if (segment === NONE) {
      panel.remark("This surface is unlabelled: there is no segment to name");
      return;
    }
    panel.naming.ask(segmentTitle(segment, names), names[segment] ?? "", place, (given) => {
      if (given !== (names[segment] ?? "")) edit({ kind: "relabel", face, name: given });
    });
  }

  /** Hide the segment under a face, or all others; null shows everything. @param {number | null} face */
  function hide(face, isIsolating = false) {
    letGo(); // what a cut would divide off is part of its segment again
    const { partition, hidden } = view;
    if (!partition) return;
    const segment = face === null ? null : view.segmentOf(face);
    const { atomSegment } = partition;
    const isHidden = (/** @type {number} */ atom) =>
      isIsolating ? atomSegment[atom] !== segment : hidden?.[atom] === 1 || atomSegment[atom] === segment;
    const isDone = hidden !== null && atomSegment.every((_, atom) => isHidden(atom) === (hidden[atom] === 1));
    if (isDone && segment !== null && !isIsolating) {
      view.hide((atom) => hidden[atom] === 1 && atomSegment[atom] !== segment); // it was hidden: show it
    } else view.hide(segment === null || (isIsolating && isDone) ? null : isHidden);
    onHide();
  }

  return { edit, walk, goTo, nameQuickly, act, hide };
}
