/** The pointer on the picture: what it is on, what is picked, and what its movements do. */

import { FINAL } from "./editor.js";
import { IDLE, step } from "./gestures.js";
import { NONE } from "./partition.js";

/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {import("./gestures.js").Hit} Hit */
/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */

const SCROLL_PAUSE_MS = 200;

/**
 * @param {object} around
 * @param {import("./wire.js").Model} around.model
 * @param {import("./viewer.js").Viewer} around.view
 * @param {ReturnType<typeof import("./panel.js").createPanel>} around.panel
 * @param {import("./labelling.js").Labelling} around.labelling
 * @param {AbortSignal} around.signal
 * @param {(edit: import("./editor.js").Edit) => void} edit
 * @param {(face: number | null, at: Vec3 | null) => void} onPoint  the pointer is on another face, or on none
 */
export function createPointing({ model, view, panel, labelling, signal }, edit, onPoint) {
  const { root, canvas } = panel;
  /** Where the pointer is; null when it is elsewhere. @type {Place | null} */
  let pointer = null;
  let gesture = IDLE;
  /** @type {number | null} */
  let hoveredFace = null;
  /** Face that a linked view points at. @type {number | null} */
  let linked = null;
  /** Segment that the list points at. @type {number | null} */
  let listed = null;
  /** Whether keys were used last: without a pointer they aim at the middle. */
  let isKeyboard = false;
  /** Where on the surface the last press was, and where the picked part was taken. */
  const points = { press: /** @type {Vec3 | null} */ (null), picked: /** @type {Vec3 | null} */ (null) };

  /** Where keys act: under the pointer, or in the middle. @returns {Place | null} */
  function aimed() {
    return pointer ?? (isKeyboard ? { x: view.size.width / 2, y: view.size.height / 2 } : null);
  }

  /** Show what lies under the pointer. @param {boolean} [isForced]  even if it is the same face as before */
  function point(isForced = false) {
    const place = aimed();
    const isPointing = ["idle", "press", "link"].includes(gesture.phase);
    const own = place && isPointing ? view.faceAt(place) : null;
    const face = own ?? (place || view.isMoving ? null : linked);
    if (face === hoveredFace && !isForced) return;
    if (face !== hoveredFace) onPoint(own, own === null || !place ? null : view.pointAt(place));
    hoveredFace = face;
    const from = gesture.phase === "link" ? gesture.from : gesture.picked;
    const part = face === null ? NONE : view.partOf(face);
    const target = from && face !== null && labelling.isTarget(from.face, face) ? view.segmentOf(face) : NONE;
    const lit = face === null && listed !== null ? listed : target;
    view.setLook({ hovered: from ? NONE : part, picked: from ? from.part : NONE, target: lit });
    panel.list.mark(face === null ? listed : view.segmentOf(face));
    root.dataset.listed = said(listed ?? NONE);
    root.dataset.hovered = said(part);
    root.dataset.picked = said(from ? from.part : NONE);
    root.dataset.target = said(target);
    const words = face !== null && view.partition ? labelling.descriptionOf(face) : null;
    panel.showHover(words && target !== NONE ? { ...words, text: `Merge into ${words.text}` } : words);
    const { picked } = gesture;
    panel.showPicked(picked ? `${labelling.titleOf(picked)}: click what to merge it with` : null);
  }

  /** The line from the part being moved to the pointer. @param {Place | null} [tip] */
  function stretch(tip = aimed()) {
    const start = gesture.phase === "link" ? points.press : gesture.picked && points.picked;
    panel.rubber.show(start && view.placeOf(start), tip, view.look.target !== NONE);
  }

  /** A hit as it is after levels or segments have changed. @param {Hit | null} hit */
  function renewed(hit) {
    const part = hit ? view.partOf(hit.face) : NONE;
    return hit && part !== NONE ? { face: hit.face, part, segment: view.segmentOf(hit.face) } : null;
  }

  /** Levels or segments have changed. */
  function renew() {
    gesture = { ...gesture, from: renewed(gesture.from), picked: renewed(gesture.picked) };
    point(true);
  }

  /** @param {PointerEventLike} event */
  function feed(event) {
    const before = gesture.picked;
    const [next, actions] = step(gesture, event, model.get("mode"));
    gesture = next;
    if (next.picked && next.picked !== before) points.picked = points.press;
    root.dataset.gesture = next.phase;
    for (const action of actions) {
      const { level } = labelling;
      if (action.kind === "merge") edit({ kind: "merge", face: action.face, onto_face: action.onto, level });
      else if (action.kind === "split") edit({ kind: "split", face: action.face, level });
      else if (action.kind !== "click") view.apply(action);
    }
    point(true);
    stretch();
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
  const on = /** @type {typeof canvas.addEventListener} */ (
    (/** @type {string} */ name, /** @type {any} */ callback) =>
      canvas.addEventListener(name, callback, { signal, passive: false })
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

  return {
    point,
    stretch,
    renew,
    letGo,
    choose,
    list,
    chooseSegment,
    aimed,
    showAim,

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
