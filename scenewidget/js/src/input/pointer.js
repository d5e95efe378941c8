/** The pointer on the picture: what it is on, what is picked, and what its movements do. */

import { counted, segmentTitle } from "../labels/description.js";
import { NONE } from "../labels/partition.js";
import { FINAL } from "../labels/prediction.js";
import { IDLE, step } from "./gestures.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */
/** @typedef {import("./gestures.js").Hit} Hit */
/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */

const SCROLL_PAUSE_MS = 200;
const HOLD_MS = 500; // a long press
const BRUSH_STEP = 5; // pixels: a fast brush misses nothing that is wider
const IS_MAC = /mac/i.test(globalThis.navigator?.platform ?? "");

/**
 * @param {object} around
 * @param {import("../wire/wire.js").Model} around.model
 * @param {import("../scene/viewer.js").Viewer} around.view
 * @param {ReturnType<typeof import("../panel/panel.js").createPanel>} around.panel
 * @param {import("../labels/shown_segments.js").Labelling} around.labelling
 * @param {ReturnType<typeof import("./cut_preview.js").createCutting>} around.cutting
 * @param {AbortSignal} around.signal
 * @param {object} to
 * @param {(edit: import("../labels/prediction.js").Edit) => void} to.edit
 * @param {(face: number | null, at: Vec3 | null) => void} to.onPoint  the pointer is on another face, or on none
 * @param {() => void} to.onTool  another tool is in hand
 */
export function createPointing(
  { model, view, panel, labelling, cutting, signal },
  { edit, onPoint, onTool },
) {
  const { root, canvas } = panel;
  /** Where the pointer is; null when it is elsewhere. @type {Place | null} */
  let pointer = null;
  let gesture = IDLE;
  /** @type {number | null} */
  let hoveredFace = null;
  /** Face that a linked view points at. @type {number | null} */
  let linked = null;
  /** An edit that is suggested: the part under a face, and where it would go (−1: off). */
  let proposal = /** @type {{ face: number, onto: number } | null} */ (null);
  /** Segment that the list points at. @type {number | null} */
  let listed = null;
  /** Whether keys were used last: without a pointer they aim at the middle. */
  let isKeyboard = false;
  /** Where on the surface the last press was, and where the picked part was taken. */
  const points = {
    press: /** @type {Vec3 | null} */ (null),
    picked: /** @type {Vec3 | null} */ (null),
    seeds: /** @type {[Vec3, Vec3] | null} */ (null), // of a cut that Python is about
  };
  /** @type {import("./gestures.js").Tool} */
  let tool = "merge";

  /** Where keys act: under the pointer, or in the middle. @returns {Place | null} */
  function aimed() {
    return pointer ?? (isKeyboard ? { x: view.size.width / 2, y: view.size.height / 2 } : null);
  }

  /** Show what lies under the pointer. @param {boolean} [isForced]  even if it is the same face as before */
  function point(isForced = false) {
    const place = aimed();
    const isPointing = ["idle", "tap", "press", "link", "dab", "brush"].includes(gesture.phase);
    const own = place && isPointing ? view.faceAt(place) : null;
    const face = own ?? (place || view.isMoving ? null : linked);
    if (face === hoveredFace && !isForced) return;
    if (face !== hoveredFace) onPoint(own, own === null || !place ? null : view.pointAt(place));
    hoveredFace = face;
    const { picked, stroke } = gesture;
    const from = gesture.phase === "link" ? gesture.from : (stroke?.onto ?? picked);
    const part = face === null ? NONE : view.partOf(face);
    const isMerge = from && face !== null && tool === "merge" && !stroke;
    const target = isMerge && labelling.isTarget(from.face, face) ? view.segmentOf(face) : NONE;
    const isCut = from !== null && tool === "cut" && !stroke;
    if (!isCut) cutting.aim(null, null);
    else if (!view.isMoving && isPointing) cutting.aim(from.face, face);
    const divided = isCut ? (labelling.offcut?.segment ?? from.segment) : NONE;
    const lit = face === null && listed !== null ? listed : isCut ? divided : target;
    const offered = proposal && !from ? view.partOf(proposal.face) : NONE;
    const goal = proposal && !from && proposal.onto >= 0 ? view.segmentOf(proposal.onto) : NONE;
    view.setLook({
      hovered: from ? NONE : part,
      picked: isCut ? NONE : from ? from.part : offered,
      target: lit === NONE ? goal : lit,
    });
    panel.list.mark(face === null ? listed : view.segmentOf(face));
    root.dataset.listed = said(listed ?? NONE);
    root.dataset.hovered = said(part);
    root.dataset.picked = said(from ? from.part : NONE);
    root.dataset.target = said(target);
    const words = face !== null && view.partition ? labelling.descriptionOf(face) : null;
    panel.showHover(words && target !== NONE ? { ...words, text: `Merge into ${words.text}` } : words);
    if (stroke) {
      const n = stroke.gathered.length;
      const what = n === 0 ? "gather parts for" : `${n} ${n === 1 ? "part" : "parts"} onto`;
      panel.showPicked(`Brush: ${what} ${labelling.titleOf(stroke.onto)}`, "stroke");
    } else if (tool === "cut") hintAtCut();
    else if (tool === "brush")
      panel.showPicked("Brush: drag over parts to gather them onto the first", "hint");
    else panel.showPicked(picked && `${labelling.titleOf(picked)}: click what to merge it with`);
  }

  /** Say what to do next with the cut tool. */
  function hintAtCut() {
    if (tool === "cut" && !gesture.stroke) panel.showPicked(cutHint(gesture.picked), "hint");
  }

  /** @param {Hit | null} picked  the first point */
  function cutHint(picked) {
    if (!picked) return "Cut: click or drag from one side of a segment to the other";
    const title = segmentTitle(picked.segment, labelling.names);
    const { offcut } = labelling;
    if (cutting.isLooking) return `${title}: looking for the cut…`;
    if (offcut) return `${title}: a click here cuts ${counted(offcut.nFaces, "face")} off`;
    return `${title}: click the other side of the cut`;
  }

  /** The line from the part being moved to the pointer. @param {Place | null} [tip] */
  function stretch(tip = aimed()) {
    const start = gesture.phase === "link" ? points.press : gesture.picked && points.picked;
    const isCut = labelling.pending.operations.some(({ kind }) => kind === "cut");
    if (!isCut) points.seeds = null;
    if (!start && points.seeds) {
      panel.rubber.show(view.placeOf(points.seeds[0]), view.placeOf(points.seeds[1]), true);
      return;
    }
    const isHeld = view.look.target !== NONE || tool === "cut";
    panel.rubber.show(start && view.placeOf(start), tip, isHeld);
  }

  /** A hit as it is after levels or segments have changed. @param {Hit | null} hit */
  function renewed(hit) {
    const part = hit ? view.partOf(hit.face) : NONE;
    return hit && part !== NONE ? { face: hit.face, part, segment: view.segmentOf(hit.face) } : null;
  }

  /** Levels or segments have changed. */
  function renew() {
    const { from, picked, stroke } = gesture;
    const onto = renewed(stroke?.onto ?? null);
    gesture = {
      ...gesture,
      from: renewed(from),
      picked: renewed(picked),
      stroke: stroke && onto && { ...stroke, onto },
    };
    point(true);
    stretch();
  }

  /** @param {PointerEventLike} event */
  function feed(event) {
    const before = gesture;
    const [next, actions] = step(gesture, event, model.get("mode"), tool);
    gesture = next;
    if (next.picked && next.picked !== before.picked) points.picked = points.press;
    root.dataset.gesture = next.phase;
    if (next.stroke?.gathered.length !== before.stroke?.gathered.length) sketch();
    for (const action of actions) {
      const { level } = labelling;
      if (action.kind === "merge") edit({ kind: "merge", face: action.face, onto_face: action.onto, level });
      else if (action.kind === "split") edit({ kind: "split", face: action.face, level });
      else if (action.kind === "cut") {
        const start = before.phase === "link" ? points.press : points.picked;
        const end = before.phase === "link" ? view.pointAt(event) : points.press;
        points.seeds = start && end && [start, end];
        edit({ kind: "cut", face_a: action.face, face_b: action.onto });
      } else if (action.kind !== "click") view.apply(action);
    }
    point(true);
    stretch();
  }

  /** Show what the brush has gathered as if it had been merged already. */
  function sketch() {
    const { stroke } = gesture;
    const faces = stroke?.gathered.map(({ face }) => face) ?? [];
    const isThere = stroke && faces.length > 0;
    labelling.sketch = isThere
      ? { kind: "merge", face: faces, onto_face: stroke.onto.face, level: labelling.level }
      : null;
    labelling.read();
    root.dataset.segments = String(labelling.count);
  }

  /** Take up a tool, or put it down if it is in hand already. @param {import("./gestures.js").Tool} wanted */
  function setTool(wanted) {
    tool = wanted === tool ? "merge" : wanted;
    root.dataset.tool = tool;
    panel.showTool(tool);
    letGo();
    onTool();
  }

  /** Let go of what is in hand, then of the tool; whether there was anything. */
  function back() {
    const isIdle = gesture.phase === "idle" && !gesture.picked && !gesture.stroke;
    if (isIdle && tool === "merge") return false;
    if (isIdle) setTool("merge");
    else letGo();
    return true;
  }

  const letGo = () => feed({ type: "cancel", id: -1, x: 0, y: 0 });

  /** Do what a click does, at the place where keys act. */
  function choose() {
    const place = aimed();
    points.press = place && view.pointAt(place);
    if (place) feed({ type: "choose", id: -1, ...place, hit: view.hitAt(place) });
  }

  /** The list points at a segment; null = no longer. @param {number | null} segment */
  function list(segment) {
    if (segment === listed) return;
    listed = segment;
    point(true);
  }

  /** What a click on its row does: pick the segment whole where that can be, else frame it. @param {number} segment */
  function chooseSegment(segment) {
    const face = view.faceOf(segment);
    if (face === null) return;
    if (model.get("mode") !== "edit" || labelling.level !== FINAL || segment === NONE) {
      view.lookAt(face);
      return;
    }
    points.press = null;
    feed({ type: "choose", id: -1, x: 0, y: 0, hit: { face, part: view.partOf(face), segment } });
  }

  /** Whether keys act on the middle of the picture. @param {boolean} isShown */
  function showAim(isShown) {
    isKeyboard = isShown;
    panel.aim.hidden = !isShown || pointer !== null;
    point();
  }

  // listening ----------------------------------------------------------------------------------------

  /** @param {MouseEvent} event */
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  /** Whether the pointer is on the picture, not on a button over it or beside it. @param {PointerEvent} event */
  const isOnCanvas = (event) => {
    const page = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    return page.elementFromPoint(event.clientX, event.clientY) === canvas;
  };
  let holdTimer = 0;
  const hold = () => feed({ type: "hold", id: -1, x: 0, y: 0 });
  /** @param {PointerEventLike["type"]} type */
  const onPointer = (type) => (/** @type {PointerEvent} */ event) => {
    const isTouch = event.pointerType === "touch";
    const place = placeOf(event);
    const isOutside = type === "cancel" || (gesture.phase !== "idle" && !isOnCanvas(event));
    const last = pointer;
    const isTap = type === "up" && gesture.phase === "tap";
    pointer = isOutside || (isTouch && type === "up" && !isTap) ? null : place;
    if (type !== "move") clearTimeout(holdTimer);
    if (isKeyboard) showAim(false);
    if (type === "down") {
      canvas.setPointerCapture(event.pointerId);
      panel.naming.close();
      root.focus({ preventScroll: true });
      points.press = view.pointAt(place);
      if (event.pointerType !== "mouse") holdTimer = window.setTimeout(hold, HOLD_MS);
    }
    if (type === "move" && gesture.phase === "idle") {
      point();
      stretch();
      return;
    }
    const hit = isOutside ? null : view.hitAt(place);
    const { pointerId: id, button, shiftKey: shift } = event;
    const brush = event.metaKey || (event.ctrlKey && !IS_MAC); // there, Ctrl makes a right click
    const kind = { id, button, shift, brush, isOutside, isTouch };
    if (type === "move" && gesture.stroke && last && !isOutside) {
      for (const between of placesBetween(last, place))
        feed({ type, ...kind, ...between, hit: view.hitAt(between) });
    }
    feed({ type, ...kind, ...place, hit });
    if (gesture.phase === "link") stretch(place);
  };
  const on = /** @type {typeof canvas.addEventListener} */ (
    (/** @type {string} */ name, /** @type {any} */ callback) =>
      canvas.addEventListener(name, callback, { signal, passive: false })
  );
  on("pointerdown", onPointer("down"));
  on("pointermove", onPointer("move"));
  on("pointerup", onPointer("up"));
  on("pointercancel", onPointer("cancel"));
  on("lostpointercapture", () => {
    if (["tap", "press", "link", "aside", "dab", "brush"].includes(gesture.phase)) letGo();
  });
  on("pointerenter", () => {
    const page = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    const { activeElement } = page; // a list or a button that was clicked on would have the keys meant for the picture
    if (activeElement !== root && root.contains(activeElement) && !panel.naming.isOpen())
      root.focus({ preventScroll: true });
  });
  on("pointerleave", (/** @type {PointerEvent} */ event) => {
    if (event.pointerType === "touch") return; // what was tapped stays pointed at
    pointer = null;
    point();
    stretch();
  });
  on("dblclick", (/** @type {MouseEvent} */ event) => {
    if (model.get("mode") === "navigate") view.recentre(placeOf(event));
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
    view.apply({ kind: "zoom", factor, ...placeOf(event) });
  };
  window.addEventListener("wheel", onWheel, { signal, passive: false, capture: true });
  root.addEventListener("focusout", () => showAim(false), { signal });
  signal.addEventListener("abort", () => clearTimeout(holdTimer));

  return {
    point,
    stretch,
    renew,
    hintAtCut,
    letGo,
    back,
    setTool,
    tool: () => tool,
    finish: () => feed({ type: "finish", id: -1, x: 0, y: 0 }),
    choose,
    list,
    chooseSegment,
    aimed,
    showAim,

    /** Light up an edit that is suggested. @param {typeof proposal} suggested */
    propose(suggested) {
      proposal = suggested;
      point(true);
    },

    /** Show what a linked view points at. @param {number | null} face */
    follow(face) {
      linked = face;
      point();
    },

    /** The picked part and where it was taken, if there is one. */
    picked() {
      const { picked } = gesture;
      return picked && { face: picked.face, place: view.placeOf(points.picked ?? [0, 0, 0]) };
    },
  };
}

/** A part or a segment for a data attribute. @param {number} number */
function said(number) {
  return number === NONE ? "" : String(number);
}

/** Places that a pointer has passed between two events. @param {Place} from @param {Place} to */
function* placesBetween(from, to) {
  const n = Math.ceil(Math.hypot(to.x - from.x, to.y - from.y) / BRUSH_STEP);
  for (let i = 1; i < n; i++) {
    yield { x: from.x + (i / n) * (to.x - from.x), y: from.y + (i / n) * (to.y - from.y) };
  }
}
