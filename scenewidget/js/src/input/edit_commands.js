/** Wishes about segments: edits go to Python and show at once; hiding and framing stay on the page. */

import { segmentTitle } from "../labels/description.js";
import { othersHidden, toggledHidden } from "../labels/hidden.js";
import { rangesOf } from "../labels/painting.js";
import { NONE } from "../labels/partition.js";
import { foresee } from "../labels/prediction.js";

/** @typedef {import("./gestures.js").Place} Place */

const PREVIEW = "This is a preview: let go of the slider, and edit the result";
const NAMELESS = "This surface is unlabeled: there is no segment to name";
const GONE = "The kernel is gone: nothing was edited. Run the cell again";

/**
 * @param {import("./messages.js").Around & { target: () => number | null }} around  target: the face that keys act on
 */
export function createEditCommands({ model, view, segments, root, target, send, on }) {
  const remark = (/** @type {string} */ text) => send({ kind: "remark", text });

  /** Show an edit and tell Python of it, unless it makes no sense. @param {import("../labels/prediction.js").Edit} operation */
  function edit(operation) {
    if (root.dataset.live === "false") return;
    if (segments.isPreview) {
      remark(PREVIEW);
      return;
    }
    const { ground, shown } = segments;
    const revision = model.get("revision");
    if (!model.get("editable") || !ground || !shown) {
      model.send({ ...told(operation), revision });
      return;
    }
    const foreseen = foresee(ground, shown.labels, operation);
    if (typeof foreseen === "string") remark(foreseen);
    else queue(operation, { revision });
  }

  /** @param {"undo" | "redo"} kind */
  function walk(kind) {
    if (root.dataset.live === "false") return;
    if (segments.isPreview) {
      remark(PREVIEW);
      return;
    }
    if (kind === "undo" && segments.sketch) {
      send({ kind: "let_go" }); // what the brush has gathered shows as the last step
      return;
    }
    if (!model.get("editable")) model.send({ kind });
    else queue({ kind }, {});
  }

  /** @param {import("../labels/prediction.js").Operation} operation @param {object} details */
  function queue(operation, details) {
    remark("");
    const answer = segments.pending.add(operation);
    try {
      model.send({ ...told(operation), ...details, ...answer });
    } catch {
      segments.pending.forget();
      remark(GONE);
    }
    send({ kind: "segments" });
  }

  /** Open the form for a name. @param {number} face @param {Place} place */
  function askName(face, place) {
    if (!model.get("editable") && model.get("mode") !== "edit") return; // nobody would take it
    const segment = segments.segmentOf(face);
    if (segment === NONE) {
      remark(NAMELESS);
      return;
    }
    const { names } = segments;
    const title = segmentTitle(segment, names);
    send({ kind: "ask_name", face, title, name: names[segment] ?? "", place });
  }

  /** @param {number} index  of the names that have keys */
  function nameQuickly(index) {
    const name = model.get("quick_names")[index];
    const face = target();
    if (!name || face === null) return;
    if (view.segmentOf(face) === NONE) remark(NAMELESS);
    else edit({ kind: "relabel", face, name });
  }

  /** @param {((atom: number) => boolean) | null} isHidden  null shows everything */
  function hide(isHidden) {
    view.hide(isHidden);
    send({ kind: "hidden" });
  }

  on({
    edit: ({ edit: operation }) => edit(operation),
    undo: () => walk("undo"),
    redo: () => walk("redo"),
    go_to({ n }) {
      if (segments.isPreview) remark(PREVIEW);
      else queue({ kind: "go_to", n }, {});
    },
    name: ({ face, name }) => edit({ kind: "relabel", face, name }),
    take_box() {
      const ranges = rangesOf(view.drawnFaces());
      if (ranges.length > 0) edit({ kind: "paint", ranges, onto_face: null });
      else remark("There is nothing in the box");
    },
    quick_name: ({ index }) => nameQuickly(index),
    show_all() {
      send({ kind: "let_go" });
      if (view.partition) hide(null);
    },
    act({ what, face, place }) {
      if (what === "frame") view.lookAt(face);
      else if (what === "name") askName(face, place ?? { x: view.size.width / 2, y: view.size.height / 2 });
      else {
        send({ kind: "let_go" }); // what a cut would divide off is part of its segment again
        if (what === "split") edit({ kind: "split", face, level: segments.level });
        else if (what === "ungroup") edit({ kind: "group", face, onto_face: null });
        else if (view.partition) {
          const change = what === "isolate" ? othersHidden : toggledHidden;
          hide(change(view.hidden, view.partition.atomSegment, view.segmentOf(face)));
        }
      }
    },
  });
}

/** An operation as Python takes it. @param {import("../labels/prediction.js").Operation} operation */
function told(operation) {
  if (operation.kind !== "slice") return operation;
  const { off: _, ...said } = operation; // what is foreseen of it
  return said;
}
