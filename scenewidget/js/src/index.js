/** Connects the model that Python holds with a view of it on the page. */

import { counted, describeFace, segmentTitle } from "./description.js";
import { canMerge, FINAL, foresee, NOTHING, Pending, replay } from "./editor.js";
import { boundingBall, vertexNormals } from "./geometry.js";
import { IDLE, step } from "./gestures.js";
import { command } from "./keys.js";
import { createPanel } from "./panel.js";
import { countSegments, makePartition, NONE } from "./partition.js";
import { watchTheme } from "./theme.js";
import { Viewer } from "./viewer.js";
import { readArray } from "./wire.js";

/** @typedef {import("./wire.js").Model} Model */
/** @typedef {import("./renderer.js").MeshArrays} MeshArrays */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */
/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("./camera.js").Vec3} Vec3 */

const GEOMETRY = ["vertices", "faces", "vertex_colors"];
const PARTITION = ["face_atom", "atom_part", "atom_segment", "segment_colors"];
const VALUES = ["face_value", "colormap"];
const SCROLL_PAUSE_MS = 200;

/** Arrays as drawn, shared by all views of a model. @type {WeakMap<Model, MeshArrays>} */
const meshes = new WeakMap();

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @returns {() => void}  undoes everything
 */
function render({ model, el }) {
  const life = new AbortController();
  const panel = createPanel(el, {
    look: (from) => viewer?.lookFrom(from),
    set: (name, value) => {
      model.set(name, value);
      model.save_changes();
    },
    cancel: () => model.send({ kind: "cancel" }),
    walk: (kind) => walk(kind),
    act: (what) => gesture.picked && act(what, gesture.picked.face, view.placeOf(points.picked ?? [0, 0, 0])),
    letGo: () => feed({ type: "cancel", id: -1, x: 0, y: 0 }),
    showAll: () => hide(null),
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
        stretch();
      },
      onRest: () => {
        root.dataset.moving = "false";
        point();
        stretch();
      },
    });
  } catch (error) {
    panel.showFailure(
      `The 3D view can't be drawn: ${messageOf(error)} It needs WebGL 2, which ` +
        "current browsers have; on a remote or virtual machine it may have to be switched on.",
    );
    return () => root.remove();
  }
  const view = viewer;

  /** Where the pointer is; null when it is elsewhere. @type {Place | null} */
  let pointer = null;
  let gesture = IDLE;
  /** @type {number | null} */
  let hoveredFace = null;
  /** Whether keys were used last: without a pointer they aim at the middle. */
  let isKeyboard = false;
  /** Where on the surface the last press was, and where the picked part was taken. */
  const points = { press: /** @type {Vec3 | null} */ (null), picked: /** @type {Vec3 | null} */ (null) };

  const pending = new Pending(Math.random().toString(36).slice(2, 10));
  /** What is shown: Python's segments with the edits on top that it hasn't answered yet. */
  let ground = /** @type {import("./editor.js").Ground | null} */ (null);
  let shown = /** @type {ReturnType<typeof replay> | null} */ (null);

  // from the model -----------------------------------------------------------------------------------

  const take = {
    geometry() {
      const mesh = meshes.get(model) ?? readMesh(model);
      if (!mesh || mesh === view.mesh) return;
      meshes.set(model, mesh);
      view.setMesh(mesh);
      measure();
    },
    partition() {
      const faceAtom = /** @type {Uint32Array | null} */ (readArray(model, "face_atom"));
      const atomSegment = /** @type {Uint32Array | null} */ (readArray(model, "atom_segment"));
      if (faceAtom && atomSegment) {
        const atomPart = /** @type {Uint32Array | null} */ (readArray(model, "atom_part"));
        const segmentColors = /** @type {Uint8Array | null} */ (readArray(model, "segment_colors"));
        pending.answered(model.get("_answers"));
        ground = { faceAtom, parts: partsOf(model.get("levels"), atomPart, atomSegment.length) };
        shown = replay(ground, { atomSegment, names: model.get("segment_names") }, pending.operations);
        const level = model.get("level") === FINAL ? -1 : model.get("levels").indexOf(model.get("level"));
        const tables = { faceAtom, atomSegment: shown.labels.atomSegment, atomPart, segmentColors };
        view.setPartition(makePartition(tables, level, view.mesh));
      } else {
        ground = shown = null;
        view.setPartition(null);
      }
      gesture = { ...gesture, from: renewed(gesture.from), picked: renewed(gesture.picked) };
      point(true);
    },
    values() {
      const values = /** @type {Uint16Array | null} */ (readArray(model, "face_value"));
      const colormap = /** @type {Uint8Array | null} */ (readArray(model, "colormap"));
      if (values && colormap) view.setValues(values, colormap);
    },
    state() {
      root.style.height = `${model.get("height")}px`;
      root.dataset.segments = String(shown ? countSegments(shown.labels.atomSegment) : 0);
      if (root.dataset.mode !== model.get("mode")) {
        root.dataset.mode = model.get("mode");
        feed({ type: "cancel", id: -1, x: 0, y: 0 });
      }
      view.setLook({
        colorBy: model.get("color_by"),
        mixing: model.get("color_mix"),
        outlines: model.get("outlines"),
        backFaces: model.get("back_faces"),
      });
      panel.update({
        colorBy: model.get("color_by"),
        hasScan: view.mesh?.colors != null,
        hasValues: readArray(model, "face_value") !== null,
        hasPartition: view.partition !== null,
        levels: model.get("levels"),
        level: model.get("level"),
        outlines: model.get("outlines"),
        backFaces: model.get("back_faces"),
        mixing: model.get("color_mix"),
        busy: model.get("busy"),
        progress: model.get("progress"),
        status: model.get("status"),
        error: model.get("error"),
        mode: model.get("mode"),
        editable: model.get("editable"),
        undo: shown?.undo ?? (model.get("undo_title") || null),
        redo: shown?.redo === NOTHING ? null : (shown?.redo ?? (model.get("redo_title") || null)),
        pending: pending.operations.length,
        nHidden: hiddenSegments(view),
        vocabulary: model.get("vocabulary"),
        summary: summaryOf(view),
        legend: legendOf(model),
      });
    },
  };

  /** Changes arrive one by one, also those that belong together: take them all at once, when they are in. */
  const changes = new Set(/** @type {Array<keyof typeof take>} */ ([]));
  const changed = (/** @type {keyof typeof take} */ what) => {
    if (changes.size === 0) queueMicrotask(takeChanges);
    changes.add(what);
  };
  const takeChanges = () => {
    if (life.signal.aborted) return;
    for (const what of /** @type {Array<keyof typeof take>} */ (["geometry", "partition", "values"])) {
      if (changes.has(what)) take[what]();
    }
    changes.clear();
    take.state();
  };
  /** @param {string[]} names @param {keyof typeof take} what */
  const listen = (names, what) => {
    const callback = () => changed(what);
    for (const name of names) model.on(`change:${name}`, callback);
    life.signal.addEventListener("abort", () => {
      for (const name of names) model.off(`change:${name}`, callback);
    });
  };
  listen(arrays(GEOMETRY), "geometry");
  listen([...arrays(PARTITION), "levels", "level", "segment_names", "_answers"], "partition");
  listen(arrays(VALUES), "values");
  listen(
    [
      ...["color_by", "color_mix", "outlines", "back_faces", "height", "mode", "editable", "vocabulary"],
      ...["busy", "progress", "status", "error", "undo_title", "redo_title", "values_legend"],
    ],
    "state",
  );
  let wasBusy = model.get("busy");
  const onStatus = () => {
    const isBusy = model.get("busy");
    if (!isBusy && !wasBusy) panel.remark(model.get("status"));
    wasBusy = isBusy;
  };
  for (const name of ["status", "busy"]) model.on(`change:${name}`, onStatus);
  life.signal.addEventListener("abort", () => {
    for (const name of ["status", "busy"]) model.off(`change:${name}`, onStatus);
  });
  const onMessage = (/** @type {any} */ message) => {
    if (message?.kind === "look") view.lookFrom(message.from);
  };
  model.on("msg:custom", onMessage);
  life.signal.addEventListener("abort", () => model.off("msg:custom", onMessage));

  // theme and size -----------------------------------------------------------------------------------

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
  model.on("change:theme", paint);
  const measure = () => {
    const { clientWidth, clientHeight } = canvas;
    view.resize(clientWidth, clientHeight);
  };
  const observer = new ResizeObserver(measure);
  observer.observe(canvas);
  life.signal.addEventListener("abort", () => {
    stopTheme();
    model.off("change:theme", paint);
    observer.disconnect();
  });

  // pointing and moving ------------------------------------------------------------------------------

  /** Where keys act: under the pointer, or in the middle. @returns {Place | null} */
  function aimed() {
    return pointer ?? (isKeyboard ? { x: view.size.width / 2, y: view.size.height / 2 } : null);
  }

  /** The part that is being moved, if there is one. */
  function source() {
    return gesture.phase === "link" ? gesture.from : gesture.picked;
  }

  /** Show what lies under the pointer. @param {boolean} [isForced]  even if it is the same face as before */
  function point(isForced = false) {
    const place = aimed();
    const isPointing = ["idle", "press", "link"].includes(gesture.phase);
    const face = place && isPointing ? view.faceAt(place) : null;
    if (face === hoveredFace && !isForced) return;
    hoveredFace = face;
    const from = source();
    const part = face === null ? NONE : view.partOf(face);
    const target = from && face !== null && isTarget(from.face, face) ? view.segmentOf(face) : NONE;
    view.setLook({ hovered: from ? NONE : part, picked: from ? from.part : NONE, target });
    root.dataset.hovered = said(part);
    root.dataset.picked = said(from ? from.part : NONE);
    root.dataset.target = said(target);
    const words = face !== null && view.partition ? descriptionOf(face) : null;
    panel.showHover(words && target !== NONE ? { ...words, text: `Merge into ${words.text}` } : words);
    panel.showPicked(gesture.picked ? `${titleOf(gesture.picked)}: click what to merge it with` : null);
  }

  /** @param {number} face @param {number} onto */
  function isTarget(face, onto) {
    const edit = /** @type {const} */ ({ kind: "merge", face, onto_face: onto, level: model.get("level") });
    return ground !== null && shown !== null && canMerge(ground, shown.labels, edit);
  }

  /** The line from the part being moved to the pointer. @param {Place | null} [tip] */
  function stretch(tip = aimed()) {
    const start = gesture.phase === "link" ? points.press : gesture.picked && points.picked;
    panel.rubber.show(start && view.placeOf(start), tip, view.look.target !== NONE);
  }

  /** What the status line says of a face. @param {number} face */
  function descriptionOf(face) {
    const partition = /** @type {import("./partition.js").Partition} */ (view.partition);
    const segment = view.segmentOf(face);
    const confidence = /** @type {Float32Array | null} */ (readArray(model, "segment_confidence"));
    const context = { level: model.get("level"), names: shown?.labels.names ?? {} };
    const isSettled = pending.operations.length === 0; // Python's table is of its own segments
    const [red, green, blue] = partition.segmentColors.subarray(3 * segment, 3 * segment + 3);
    return {
      text: describeFace(partition, face, { ...context, confidence: isSettled ? confidence : null }),
      color: segment === NONE || blue === undefined ? null : `rgb(${red} ${green} ${blue})`,
    };
  }

  /** @param {import("./gestures.js").Hit} hit */
  function titleOf({ part, segment }) {
    const level = model.get("level");
    return part === segment ? segmentTitle(segment, shown?.labels.names ?? {}) : `Part of level ${level}`;
  }

  /** A hit as it is after levels or segments have changed. @param {import("./gestures.js").Hit | null} hit */
  function renewed(hit) {
    const part = hit ? view.partOf(hit.face) : NONE;
    return hit && part !== NONE ? { face: hit.face, part, segment: view.segmentOf(hit.face) } : null;
  }

  /** @param {PointerEvent} event */
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  /** @param {PointerEventLike} event */
  function feed(event) {
    const before = gesture.picked;
    const [next, actions] = step(gesture, event, model.get("mode"));
    gesture = next;
    if (next.picked && next.picked !== before) points.picked = points.press;
    root.dataset.gesture = next.phase;
    for (const action of actions) {
      const level = model.get("level");
      if (action.kind === "merge") edit({ kind: "merge", face: action.face, onto_face: action.onto, level });
      else if (action.kind === "split") edit({ kind: "split", face: action.face, level });
      else if (action.kind !== "click") view.apply(action);
    }
    point(true);
    stretch();
  }
  /** Whether the pointer is on the picture, not on a button over it or beside it. @param {PointerEvent} event */
  const isOnCanvas = (event) => {
    const page = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    return page.elementFromPoint(event.clientX, event.clientY) === canvas;
  };
  /** @param {PointerEventLike["type"]} type */
  const onPointer = (type) => (/** @type {PointerEvent} */ event) => {
    const place = placeOf(event);
    const isOutside = type === "cancel" || (gesture.phase !== "idle" && !isOnCanvas(event));
    pointer = isOutside ? null : place;
    if (isKeyboard) showAim(false);
    if (type === "down") {
      canvas.setPointerCapture(event.pointerId);
      panel.naming.close();
      root.focus({ preventScroll: true });
      points.press = view.pointAt(place);
    }
    if (type === "move" && gesture.phase === "idle") {
      point();
      stretch();
      return;
    }
    const hit = isOutside ? null : view.hitAt(place);
    const { pointerId: id, button, shiftKey: shift } = event;
    feed({ type, id, ...place, button, shift, isTouch: event.pointerType === "touch", hit });
    if (gesture.phase === "link") stretch(place);
  };
  const letGo = () => feed({ type: "cancel", id: -1, x: 0, y: 0 });
  const on = /** @type {typeof canvas.addEventListener} */ (
    (/** @type {string} */ name, /** @type {any} */ callback) =>
      canvas.addEventListener(name, callback, { signal: life.signal, passive: false })
  );
  on("pointerdown", onPointer("down"));
  on("pointermove", onPointer("move"));
  on("pointerup", onPointer("up"));
  on("pointercancel", onPointer("cancel"));
  on("lostpointercapture", () => {
    if (gesture.phase === "press" || gesture.phase === "link" || gesture.phase === "aside") letGo();
  });
  on("pointerleave", () => {
    pointer = null;
    point();
    stretch();
  });
  on("dblclick", (/** @type {MouseEvent} */ event) => {
    if (model.get("mode") === "navigate") view.recentre(placeOf(/** @type {PointerEvent} */ (event)));
  });
  on("webglcontextlost", () => {
    view.lose();
    letGo();
    root.dataset.ready = "false";
  });
  on("webglcontextrestored", () => {
    view.restore();
    root.dataset.ready = "true";
  });

  // a scroll that began outside goes on scrolling the page
  let lastScroll = -Infinity;
  /** @param {WheelEvent} event */
  const onWheel = (event) => {
    const isInside = event.composedPath().includes(canvas);
    const isPassing = event.timeStamp - lastScroll < SCROLL_PAUSE_MS && !event.ctrlKey;
    if (!isInside || isPassing) {
      lastScroll = event.timeStamp;
      return;
    }
    event.preventDefault();
    event.stopPropagation();
    const lines = event.deltaMode === 1 ? 16 : 1;
    const factor = Math.exp(
      Math.max(-0.5, Math.min(0.5, event.deltaY * lines * (event.ctrlKey ? 0.01 : 0.0018))),
    );
    view.apply({ kind: "zoom", factor, ...placeOf(/** @type {any} */ (event)) });
  };
  window.addEventListener("wheel", onWheel, { signal: life.signal, passive: false, capture: true });
  root.addEventListener(
    "contextmenu",
    (event) => {
      event.preventDefault();
      event.stopPropagation();
    },
    { signal: life.signal },
  );
  root.addEventListener("keydown", onKey, { signal: life.signal });

  root.addEventListener("focusout", () => showAim(false), { signal: life.signal });

  /** Whether keys act on the middle of the picture. @param {boolean} isShown */
  function showAim(isShown) {
    isKeyboard = isShown;
    panel.aim.hidden = !isShown || pointer !== null;
    point();
  }

  /** @param {KeyboardEvent} event */
  function onKey(event) {
    const target = event.target instanceof HTMLElement ? event.target : root;
    if (target.matches("select, input") && event.key !== "Escape") return;
    if (target.matches("button") && (event.key === "Enter" || event.key === " ")) return;
    const ordered = command(event, model.get("mode"));
    if (!ordered) return;
    event.preventDefault();
    event.stopPropagation();
    showAim(target === root);
    const place = aimed();
    const face = place && view.faceAt(place);
    switch (ordered.kind) {
      case "orbit":
      case "pan":
        view.apply(ordered);
        break;
      case "zoom":
        view.apply({ ...ordered, x: view.size.width / 2, y: view.size.height / 2 });
        break;
      case "look":
        view.lookFrom(ordered.from);
        break;
      case "level":
        if (ordered.index < model.get("levels").length) set("level", model.get("levels")[ordered.index]);
        break;
      case "toggle":
        if (ordered.what === "help") panel.showHelp(!panel.isHelpShown());
        else if (ordered.what !== "mode") set(ordered.what, !model.get(ordered.what));
        else if (model.get("editable")) set("mode", model.get("mode") === "edit" ? "navigate" : "edit");
        break;
      case "escape":
        if (panel.isHelpShown()) panel.showHelp(false);
        else letGo();
        break;
      case "choose":
        points.press = place && view.pointAt(place);
        if (place) feed({ type: "choose", id: -1, ...place, hit: view.hitAt(place) });
        break;
      case "part":
        if (face !== null) act(ordered.what, face, place);
        else if (gesture.picked) act(ordered.what, gesture.picked.face, place);
        else if (ordered.what === "frame") view.lookFrom("here");
        break;
      case "show_all":
        hide(null);
        break;
      default:
        walk(ordered.kind);
    }
  }

  // what is done to a part ---------------------------------------------------------------------------

  /** @param {import("./keys.js").PartAction} what @param {number} face @param {Place | null} place */
  function act(what, face, place) {
    const segment = view.segmentOf(face);
    switch (what) {
      case "split":
        letGo();
        edit({ kind: "split", face, level: model.get("level") });
        break;
      case "name":
        name(face, place ?? { x: view.size.width / 2, y: view.size.height / 2 });
        break;
      case "frame":
        view.lookAt(face);
        break;
      default:
        hide(segment, what === "isolate");
    }
  }

  /** @param {number} face @param {Place} place */
  function name(face, place) {
    const segment = view.segmentOf(face);
    const names = shown?.labels.names ?? {};
    if (segment === NONE) {
      panel.remark("This surface is unlabelled: there is no segment to name");
      return;
    }
    panel.naming.ask(segmentTitle(segment, names), names[segment] ?? "", place, (given) => {
      if (given !== (names[segment] ?? "")) edit({ kind: "relabel", face, name: given });
    });
  }

  /** Hide a segment, or all others; null shows everything. @param {number | null} segment */
  function hide(segment, isIsolating = false) {
    const { partition, hidden } = view;
    if (!partition) return;
    const { atomSegment } = partition;
    const isHidden = (/** @type {number} */ atom) =>
      isIsolating ? atomSegment[atom] !== segment : hidden?.[atom] === 1 || atomSegment[atom] === segment;
    const isDone = hidden !== null && atomSegment.every((_, atom) => isHidden(atom) === (hidden[atom] === 1));
    view.hide(segment === null || (isIsolating && isDone) ? null : isHidden);
    letGo();
    take.state();
  }

  /** Show an edit and tell Python of it, unless it makes no sense. @param {import("./editor.js").Edit} operation */
  function edit(operation) {
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
    if (!model.get("editable")) model.send({ kind });
    else queue({ kind }, {});
  }

  /** @param {import("./editor.js").Operation} operation @param {object} details */
  function queue(operation, details) {
    panel.remark("");
    model.send({ ...operation, ...details, ...pending.add(operation) });
    take.partition();
    take.state();
  }

  /** @param {string} name @param {unknown} value */
  function set(name, value) {
    model.set(name, value);
    model.save_changes();
  }

  for (const what of /** @type {Array<keyof typeof take>} */ (["geometry", "partition", "values"]))
    take[what]();
  take.state();

  return () => {
    life.abort();
    view.dispose();
    root.remove();
  };
}

/** @param {string[]} names */
function arrays(names) {
  return names.map((name) => `_${name}`);
}

/**
 * @param {Model} model
 * @returns {MeshArrays | null}
 */
function readMesh(model) {
  const vertices = /** @type {Float32Array | null} */ (readArray(model, "vertices"));
  const faces = /** @type {Uint32Array | null} */ (readArray(model, "faces"));
  const colors = /** @type {Uint8Array | null} */ (readArray(model, "vertex_colors"));
  if (!vertices || !faces) return null;
  return { vertices, faces, colors, normals: vertexNormals(vertices, faces), bounds: boundingBall(vertices) };
}

/** @param {Viewer} view */
function summaryOf(view) {
  if (!view.mesh) return "";
  const n = view.partition ? countSegments(view.partition.atomSegment) : 0;
  return [counted(view.mesh.faces.length / 3, "face"), view.partition ? counted(n, "segment") : ""]
    .filter(Boolean)
    .join("  ·  ");
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

/** How many segments are hidden, at least in part. @param {Viewer} view */
function hiddenSegments({ hidden, partition }) {
  if (!hidden || !partition) return 0;
  return new Set(partition.atomSegment.filter((_, atom) => hidden[atom] === 1)).size;
}

/** A part or a segment for a data attribute. @param {number} number */
function said(number) {
  return number === NONE ? "" : String(number);
}

/** @param {Model} model */
function legendOf(model) {
  const colormap = readArray(model, "colormap");
  if (!colormap) return null;
  const colors = [];
  for (let i = 0; i < 256; i += 15) colors.push(`rgb(${colormap.slice(3 * i, 3 * i + 3).join(" ")})`);
  return { ...model.get("values_legend"), colors };
}

/** @param {unknown} error */
function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

export default { render };
