/** Connects the model that Python holds with a view of it on the page. */

import { boundingBall, vertexNormals } from "./geometry.js";
import { IDLE, step } from "./gestures.js";
import { command } from "./keys.js";
import { createPanel } from "./panel.js";
import { describe, makePartition, NONE } from "./partition.js";
import { watchTheme } from "./theme.js";
import { Viewer } from "./viewer.js";
import { readArray } from "./wire.js";

/** @typedef {import("./wire.js").Model} Model */
/** @typedef {import("./renderer.js").MeshArrays} MeshArrays */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */

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
      },
      onRest: () => {
        root.dataset.moving = "false";
        hover(pointer);
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

  /** Where the pointer is; null when it is elsewhere. @type {import("./gestures.js").Place | null} */
  let pointer = null;
  let gesture = IDLE;
  /** @type {number | null} */
  let hoveredFace = null;

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
        const level = model.get("levels").indexOf(model.get("level"));
        view.setPartition(makePartition({ faceAtom, atomSegment, atomPart, segmentColors }, level));
      } else {
        view.setPartition(null);
      }
      hover(pointer, true);
    },
    values() {
      const values = /** @type {Uint16Array | null} */ (readArray(model, "face_value"));
      const colormap = /** @type {Uint8Array | null} */ (readArray(model, "colormap"));
      if (values && colormap) view.setValues(values, colormap);
    },
    state() {
      root.style.height = `${model.get("height")}px`;
      root.dataset.segments = String(model.get("n_segments"));
      root.dataset.mode = model.get("mode");
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
        summary: summaryOf(model, view),
        legend: legendOf(model),
      });
    },
  };

  /** Changes arrive one by one, also those that belong together: take them all at once, when they are in. */
  const pending = new Set(/** @type {Array<keyof typeof take>} */ ([]));
  const changed = (/** @type {keyof typeof take} */ what) => {
    if (pending.size === 0) queueMicrotask(takePending);
    pending.add(what);
  };
  const takePending = () => {
    if (life.signal.aborted) return;
    for (const what of /** @type {Array<keyof typeof take>} */ (["geometry", "partition", "values"])) {
      if (pending.has(what)) take[what]();
    }
    pending.clear();
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
  listen([...arrays(PARTITION), "levels", "level"], "partition");
  listen(arrays(VALUES), "values");
  listen(
    [
      ...["color_by", "color_mix", "outlines", "back_faces", "height", "mode"],
      ...["busy", "progress", "status", "error", "n_segments", "segment_names", "values_legend"],
    ],
    "state",
  );
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

  /** @param {import("./gestures.js").Place | null} place @param {boolean} [isForced] */
  function hover(place, isForced = false) {
    const face = place && gesture.phase === "idle" ? view.faceAt(place) : null;
    if (face === hoveredFace && !isForced) return;
    hoveredFace = face;
    const hit = place && face !== null ? view.hitAt(place) : null;
    const part = hit?.part ?? NONE;
    if (part !== view.look.hovered) {
      view.setLook({ hovered: part });
      root.dataset.hovered = hit ? String(part) : "";
    } else if (!isForced) return;
    panel.showHover(face !== null && view.partition ? descriptionOf(model, view, face) : null);
  }

  /** @param {PointerEvent} event */
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  /** @param {PointerEventLike} event */
  const feed = (event) => {
    const [next, actions] = step(gesture, event, model.get("mode"));
    gesture = next;
    view.setLook({ picked: (next.phase === "link" ? next.from : next.picked)?.part ?? NONE });
    root.dataset.gesture = next.phase;
    for (const action of actions) {
      if (action.kind === "merge" || action.kind === "split") {
        const { kind, face } = action;
        const onto = action.kind === "merge" ? { onto_face: action.onto } : {};
        model.send({ kind, face, ...onto, level: model.get("level"), revision: model.get("revision") });
      } else if (action.kind !== "click") view.apply(action);
    }
  };
  /** @param {PointerEventLike["type"]} type */
  const onPointer = (type) => (/** @type {PointerEvent} */ event) => {
    const place = placeOf(event);
    pointer = type === "cancel" ? null : place;
    if (type === "down") {
      canvas.setPointerCapture(event.pointerId);
      root.focus({ preventScroll: true });
    }
    if (type === "move" && gesture.phase === "idle") {
      hover(place);
      return;
    }
    const hit = view.hitAt(place);
    const { pointerId: id, button, shiftKey: shift } = event;
    feed({ type, id, ...place, button, shift, isTouch: event.pointerType === "touch", hit });
    hover(pointer, true);
  };
  const on = /** @type {typeof canvas.addEventListener} */ (
    (/** @type {string} */ name, /** @type {any} */ callback) =>
      canvas.addEventListener(name, callback, { signal: life.signal, passive: false })
  );
  on("pointerdown", onPointer("down"));
  on("pointermove", onPointer("move"));
  on("pointerup", onPointer("up"));
  on("pointercancel", onPointer("cancel"));
  on("pointerleave", () => {
    pointer = null;
    hover(null);
  });
  on("dblclick", (/** @type {MouseEvent} */ event) => {
    if (model.get("mode") === "navigate") view.recentre(placeOf(/** @type {PointerEvent} */ (event)));
  });
  on("webglcontextlost", () => {
    view.lose();
    gesture = IDLE;
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

  /** @param {KeyboardEvent} event */
  function onKey(event) {
    const isControl = event.target instanceof HTMLElement && event.target.matches("select, input");
    if (isControl && event.key !== "Escape") return;
    const ordered = command(event, model.get("mode"));
    if (!ordered) return;
    event.preventDefault();
    event.stopPropagation();
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
        else set(ordered.what, !model.get(ordered.what));
        break;
      case "escape":
        if (panel.isHelpShown()) panel.showHelp(false);
        else feed({ type: "cancel", id: -1, x: 0, y: 0 });
        break;
      default:
        model.send({ kind: ordered.kind });
    }
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

/**
 * @param {Model} model
 * @param {Viewer} view
 */
function summaryOf(model, view) {
  if (!view.mesh) return "";
  const n = model.get("n_segments");
  return [
    counted(view.mesh.faces.length / 3, "face"),
    view.partition ? counted(n, "segment") : "",
    model.get("busy") ? "" : model.get("status"),
  ]
    .filter(Boolean)
    .join("  ·  ");
}

/**
 * What the status line says of a face: its segment, and its part if that is something else.
 * @param {Model} model
 * @param {Viewer} view
 * @param {number} face
 */
function descriptionOf(model, view, face) {
  const partition = /** @type {import("./partition.js").Partition} */ (view.partition);
  const { part, segment, partFaces, segmentFaces } = describe(partition, face);
  const name = model.get("segment_names")[segment];
  const isSame = part === NONE || partFaces === segmentFaces;
  const [red, green, blue] = partition.segmentColors.subarray(3 * segment, 3 * segment + 3);
  const text = [
    segment === NONE ? "Unlabelled" : `Segment ${segment}${name ? ` (${name})` : ""}`,
    segment === NONE ? "" : counted(segmentFaces, "face"),
    isSame ? "" : `${model.get("level")} part ${part}, ${counted(partFaces, "face")}`,
  ];
  return {
    text: text.filter(Boolean).join("  ·  "),
    color: segment === NONE || blue === undefined ? null : `rgb(${red} ${green} ${blue})`,
  };
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

/** @param {number} n @param {string} noun */
function counted(n, noun) {
  return `${n.toLocaleString("en")} ${noun}${n === 1 ? "" : "s"}`;
}

export default { render };
