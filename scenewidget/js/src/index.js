/** Connects the model that Python holds with a view of it on the page. */

import { createCutting } from "./input/cut_preview.js";
import { createEditing } from "./input/edit_commands.js";
import { listenToKeys } from "./input/keyboard.js";
import { FIRST_STEPS, FIRST_TOUCHES } from "./input/keys.js";
import { createLinking } from "./input/linked_views.js";
import { createPointing } from "./input/pointer.js";
import { counted, summary } from "./labels/description.js";
import { faceValues } from "./labels/face_values.js";
import { countHidden, facesOf } from "./labels/hidden.js";
import { Preview } from "./labels/preview.js";
import { segmentRows } from "./labels/segment_rows.js";
import { Labelling } from "./labels/shown_segments.js";
import { legendOf } from "./panel/legend.js";
import { createPanel } from "./panel/panel.js";
import { createSuggesting } from "./panel/suggestion_bar.js";
import { watchTheme } from "./panel/theme.js";
import { readMesh } from "./scene/mesh.js";
import { Viewer } from "./scene/viewer.js";
import { ASIDE, GONE_NOTICE, watchConnection } from "./wire/connection.js";
import { listen, on } from "./wire/listen.js";
import { readArray } from "./wire/wire.js";

/** @typedef {import("./wire/wire.js").Model} Model */

const GEOMETRY = ["vertices", "faces", "vertex_colors", "up"];
const PARTITION = ["face_atom", "atom_part", "atom_segment", "segment_colors", "atom_confidence"];
const VALUES = ["face_value", "colormap", "face_error"];
const PREVIEW = [
  ...["face_item", "preview_segment", "preview_colors", "is_preview"],
  ...["face_piece", "family_merges", "family_colors"],
];

const ASIDE_MS = 4000; // without its context for so long, a view won't get it back by itself
const PATIENCE_MS = 5000; // a view that loses its context sooner is one of too many in sight: leave it to a button
const LOST_MS = 8000; // an answer that takes longer may never come

/** Pieces of state, by what is taken when they change. */
const GROUPS = {
  geometry: arrays(GEOMETRY),
  partition: [...arrays(PARTITION), ...arrays(PREVIEW), "levels", "level", "segment_names", "_answers"],
  values: arrays(VALUES),
  state: [
    ...["color_by", "color_mix", "errors_title", "values_legend", "outlines", "back_faces", "section"],
    ...["height", "segment_list", "mode", "editable", "vocabulary", "quick_names"],
    ...["busy", "progress", "status", "error", "save_state", "save_note", "notices"],
    ...["undo_title", "redo_title", "history_shown", "history", "n_done"],
  ],
};

const firstSteps = globalThis.matchMedia?.("(pointer: coarse)").matches ? FIRST_TOUCHES : FIRST_STEPS;

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @returns {() => void}  undoes everything
 */
function render(host) {
  let view = start(host, again, {});
  function again() {
    const kept = view.keep();
    view.stop();
    view = start(host, again, kept);
  }
  return () => view.stop();
}

/**
 * What one page alone knows of a view, for the one that takes its place.
 * @typedef {object} Kept
 * @property {import("./scene/camera.js").Camera} [camera]
 * @property {import("./scene/camera.js").Camera | null} [outside]
 * @property {import("./input/gestures.js").Tool} [tool]
 * @property {boolean} [isSectionShown]
 */

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @param {() => void} again  ends this view and makes another in its place
 * @param {Kept} kept  of the view before
 * @returns {{ stop: () => void, keep: () => Kept }}  stop undoes everything
 */
function start({ model, el }, again, kept) {
  const life = new AbortController();
  const { signal } = life;
  const set = (/** @type {string} */ name, /** @type {unknown} */ value) => {
    model.set(name, value);
    model.save_changes();
  };
  const panel = createPanel(el, {
    look: (from) => viewer?.lookFrom(from),
    goInside: (isInside) => viewer?.goInside(isInside),
    section: {
      set: (ranges) => set("section", ranges),
      ceiling: () => set("section", view.openedAbove),
      leave: () => root.focus({ preventScroll: true }),
    },
    set,
    cancel: () => model.send({ kind: "cancel" }),
    walk: (kind) => editing.walk(kind),
    act: (what) => {
      const picked = pointing.picked();
      if (picked) editing.act(what, picked.face, picked.place);
    },
    letGo: () => pointing.back(),
    setTool: (tool) => pointing.setTool(tool),
    finish: () => pointing.finish(),
    showAll: () => editing.hide(null),
    save: () => model.send({ kind: "save" }),
    goTo: (n) => editing.goTo(n),
    choose: (notice, action) => {
      if (notice === ASIDE.key) {
        again();
        return;
      }
      if (action === "forget") labelling.pending.forget();
      else model.send({ kind: "choose", notice, action });
      root.focus({ preventScroll: true });
    },
    list: {
      point: (segment) => pointing.list(segment),
      choose: (segment) => pointing.chooseSegment(segment),
      act: (what, segment) => {
        const face = view.faceOf(segment);
        if (face !== null) editing.act(what, face, null);
      },
      close: () => {
        set("segment_list", false);
        root.focus({ preventScroll: true });
      },
    },
  });
  const { root, canvas } = panel;

  /** @type {Viewer | null} */
  let viewer = null;
  try {
    viewer = new Viewer(canvas, {
      onFirstFrame: () => {
        root.dataset.ready = "true";
      },
      onFailure: (error) => panel.showFailure(`The 3D view has stopped: ${messageOf(error)}`),
      onMove: () => {
        root.dataset.moving = "true";
        if (viewer) panel.showInside(viewer.isInside);
        pointing.stretch();
        linking.place();
      },
      onCamera: (camera) => linking.moved(camera),
      onRest: () => {
        root.dataset.moving = "false";
        pointing.point();
        pointing.stretch();
        linking.place();
        keepCamera();
      },
    });
  } catch (error) {
    panel.showFailure(
      `The 3D view can't be drawn: ${messageOf(error)} It needs WebGL 2, which ` +
        "current browsers have; on a remote or virtual machine it may have to be switched on.",
    );
    return { stop: () => root.remove(), keep: () => kept };
  }
  const view = viewer;
  /** Whether the browser has taken the graphics context away, for others. */
  let isAside = false;
  const camera = kept.camera ?? model.get("_camera");
  if (camera?.target) view.first = camera;
  view.outside = kept.outside ?? null;
  const preview = new Preview(model, () => take(new Set(/** @type {const} */ (["partition"]))), signal);
  const labelling = new Labelling(model, view, preview);
  const around = { model, view, panel, labelling, signal };
  const linking = createLinking(around, (face) => pointing.follow(face));
  const cutting = createCutting(around, {
    onOffcut: () => take(new Set(/** @type {const} */ (["partition"]))),
    onLook: () => pointing.hintAtCut(),
  });
  const pointing = createPointing(
    { ...around, cutting },
    {
      edit: (operation) => editing.edit(operation),
      onPoint: linking.pointed,
      onTool: () => take(new Set()),
    },
  );
  const editing = createEditing(around, {
    onEdit: () => take(new Set(/** @type {const} */ (["partition"]))),
    onHide: () => {
      keepHidden();
      take(new Set());
    },
    letGo: () => pointing.letGo(),
  });
  createSuggesting({ ...around, pointing });
  listenToKeys({ ...around, pointing, editing });
  const connection = watchConnection(model, el, () => take(new Set()), signal);

  // from the model -----------------------------------------------------------------------------------

  /** Take what has changed; the state always. @param {Set<keyof typeof GROUPS>} groups */
  function take(groups) {
    if (groups.has("geometry")) takeGeometry();
    if (groups.has("partition")) {
      labelling.read();
      keepHidden();
      pointing.renew();
    }
    takeValues();
    takeState();
  }

  function takeGeometry() {
    const mesh = readMesh(model);
    if (!mesh || mesh === view.mesh) return;
    view.setMesh(mesh);
    measure();
  }

  /** What was drawn last. @type {ReturnType<typeof faceValues>} */
  let drawn = null;

  function takeValues() {
    const wanted = faceValues(model);
    if (!wanted || (wanted.values === drawn?.values && wanted.colormap === drawn.colormap)) return;
    drawn = wanted;
    view.setValues(wanted.values, wanted.colormap);
  }

  function takeState() {
    root.style.height = `${model.get("height")}px`;
    root.dataset.segments = String(labelling.count);
    const isLive = connection.isLive();
    root.dataset.live = String(isLive);
    if (!isLive && model.get("mode") === "edit") model.set("mode", "navigate");
    const lost = lostEdits();
    const gone = isLive || lost.length > 0 ? [] : [GONE_NOTICE]; // one bar says that the kernel is gone
    root.dataset.preview = String(labelling.isPreview);
    panel.preview.hidden = !labelling.isPreview;
    const words = labelling.undo ? "Preview: your edits come back when you let go" : "Preview";
    if (panel.preview.textContent !== words) panel.preview.textContent = words;
    if (root.dataset.mode !== model.get("mode")) {
      root.dataset.mode = model.get("mode");
      pointing.letGo();
    }
    view.setLook({
      colorBy: model.get("color_by"),
      mixing: model.get("color_mix"),
      outlines: model.get("outlines"),
      backFaces: model.get("back_faces"),
    });
    view.setSection(model.get("section"));
    const isFirstStep =
      model.get("mode") === "edit" && pointing.tool() === "merge" && !labelling.undo && !labelling.redo;
    panel.update({
      colorBy: model.get("color_by"),
      hasScan: view.mesh?.colors != null,
      errorsTitle: model.get("errors_title"),
      hasValues: readArray(model, "face_value") !== null,
      valuesTitle: model.get("values_legend").title ?? "",
      hasPartition: view.partition !== null,
      hasConfidence: view.partition?.atomConfidence != null,
      levels: model.get("levels"),
      level: model.get("level"),
      outlines: model.get("outlines"),
      backFaces: model.get("back_faces"),
      segmentList: model.get("segment_list"),
      section: model.get("section"),
      lengths: view.lengths,
      mixing: model.get("color_mix"),
      busy: model.get("busy"),
      progress: model.get("progress"),
      status: isFirstStep && !model.get("busy") ? "" : model.get("status"),
      error: model.get("error"),
      mode: model.get("mode"),
      editable: model.get("editable") && isLive,
      undo: labelling.undo,
      redo: labelling.redo,
      pending: labelling.pending.operations.length,
      nHidden: countHidden(view.hidden, view.partition),
      vocabulary: model.get("vocabulary"),
      saveState: model.get("save_state"),
      saveNote: model.get("save_note"),
      notices: [...gone, ...(isAside ? [ASIDE] : []), ...lost, ...model.get("notices")],
      quickNames: model.get("quick_names"),
      historyShown: model.get("history_shown"),
      history: model.get("history"),
      nDone: model.get("n_done"),
      summary: isFirstStep
        ? firstSteps
        : view.mesh
          ? summary(view.mesh.faces.length / 3, view.partition)
          : "",
      legend: legendOf(model),
    });
    if (panel.list.isShown() && view.partition) {
      const { names, confidence } = labelling;
      panel.list.update(segmentRows(view.partition, { names, confidence, hidden: view.hidden }));
    }
  }

  let lostTimer = 0;
  /** What to say of edits that nobody answers. @returns {import("./panel/autosave.js").Notice[]} */
  function lostEdits() {
    const { age, operations } = labelling.pending;
    clearTimeout(lostTimer);
    if (operations.length === 0) return [];
    if (age < LOST_MS && connection.isLive()) {
      lostTimer = window.setTimeout(takeState, LOST_MS - age);
      return [];
    }
    const edits = counted(operations.length, "edit");
    const text = !connection.isLive()
      ? `The kernel is gone and has not answered ${edits}. Run the cell again: what was saved is offered there`
      : `No answer from the kernel to ${edits} yet. If it is busy, they will be done; if it was restarted, ` +
        "they are lost: run the cell again";
    return [{ key: "lost", text, actions: [["Take them back", "forget"]] }];
  }

  const onPending = () => take(new Set(/** @type {const} */ (["partition"])));
  labelling.pending.watchers.add(onPending);
  signal.addEventListener("abort", () => {
    labelling.pending.watchers.delete(onPending);
    clearTimeout(lostTimer);
  });

  /** Remember where one looks from, for pages that open or are saved later. */
  function keepCamera() {
    const isKept = JSON.stringify(view.camera) === JSON.stringify(model.get("_camera"));
    if (view.camera !== view.start && !isKept) set("_camera", view.camera);
  }

  /** What is hidden, as far as the model knows it. @type {Uint8Array | null | undefined} */
  let toldHidden;
  /** Hide what was hidden last, then remember what is, for pages that open or are saved later. */
  function keepHidden() {
    const { partition } = view;
    if (!partition || labelling.isPreview) return;
    if (toldHidden === undefined) {
      const atoms = new Set(
        (model.get("_hidden") ?? []).map((/** @type {number} */ face) => partition.faceAtom[face]),
      );
      if (atoms.size > 0) view.hide((atom) => atoms.has(atom));
    } else if (toldHidden !== view.hidden) set("_hidden", facesOf(view.hidden, partition.faceAtom));
    toldHidden = view.hidden;
  }

  listen(model, GROUPS, take, signal);
  let wasBusy = model.get("busy");
  const onStatus = () => {
    const isBusy = model.get("busy");
    if (!isBusy && !wasBusy) panel.remark(model.get("status"));
    else if (!wasBusy) panel.remark(""); // what came just before tells of this computation
    wasBusy = isBusy;
  };
  for (const name of ["status", "busy"]) on(model, `change:${name}`, onStatus, signal);
  const onMessage = (/** @type {any} */ message) => {
    if (message?.kind === "look") view.lookFrom(message.from);
  };
  on(model, "msg:custom", onMessage, signal);

  // theme, size and the graphics context ---------------------------------------------------------------

  let isHostDark = false;
  const paint = () => {
    const theme = model.get("theme");
    const isDark = theme === "auto" ? isHostDark : theme === "dark";
    root.dataset.theme = isDark ? "dark" : "light";
    view.setLook({ isDark });
  };
  const stopTheme = watchTheme(root, (isDark) => {
    isHostDark = isDark;
    paint();
  });
  on(model, "change:theme", paint, signal);
  const measure = () => {
    const { clientWidth, clientHeight } = canvas;
    view.resize(clientWidth, clientHeight);
  };
  const observer = new ResizeObserver(measure);
  observer.observe(canvas);
  let asideTimer = 0;
  const onLost = () => {
    view.lose();
    pointing.letGo();
    root.dataset.ready = "false";
    clearTimeout(asideTimer);
    asideTimer = window.setTimeout(() => {
      isAside = true;
      if (wasSeen && performance.now() - began > PATIENCE_MS) again();
      else take(new Set());
    }, ASIDE_MS);
  };
  const onRestored = () => {
    clearTimeout(asideTimer);
    isAside = false;
    take(new Set());
    view.restore();
    root.dataset.ready = "true";
  };
  canvas.addEventListener("webglcontextlost", onLost, { signal });
  canvas.addEventListener("webglcontextrestored", onRestored, { signal });
  const onMenu = (/** @type {Event} */ event) => {
    event.preventDefault();
    event.stopPropagation();
  };
  root.addEventListener("contextmenu", onMenu, { signal });
  signal.addEventListener("abort", () => {
    stopTheme();
    observer.disconnect();
    scrolling.disconnect();
    clearTimeout(asideTimer);
  });
  const began = performance.now();
  let wasSeen = false;
  const scrolling = new IntersectionObserver(([{ isIntersecting }]) => {
    if (isIntersecting && !wasSeen && isAside) again();
    wasSeen = isIntersecting;
  });
  scrolling.observe(canvas);

  take(new Set(/** @type {const} */ (["geometry", "partition", "values"])));
  if (kept.tool) pointing.setTool(kept.tool);
  if (kept.isSectionShown) panel.section.show(true, { isFocused: false });

  return {
    stop: () => {
      life.abort();
      view.dispose();
      root.remove();
    },
    keep: () => ({
      camera: view.camera,
      outside: view.outside,
      tool: pointing.tool(),
      isSectionShown: panel.section.isShown(),
    }),
  };
}

/** @param {string[]} names */
function arrays(names) {
  return names.map((name) => `_${name}`);
}

/** @param {unknown} error */
function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

export { savedModel } from "./wire/saved_model.js";
export default { render };
