/** Events of mouse, pen and finger on the picture, as gestures take them. */

import { placeOn } from "./place.js";

/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */

const HOLD_MS = 500; // a long press
const BRUSH_STEP = 5; // pixels: a fast brush misses nothing that is wider
const IS_MAC = /mac/i.test(globalThis.navigator?.platform ?? "");
const DOWN = ["tap", "press", "link", "aside", "dab", "brush", "paint", "trace"]; // phases that end when the pointer is taken away

/**
 * @param {import("./messages.js").Around & {
 *   canvas: HTMLCanvasElement,
 *   hand: import("./hand.js").Hand,
 *   aim: import("./aim.js").Aim,
 * }} around
 */
export function listenToPointer({ model, view, root, canvas, hand, aim, signal }) {
  let holdTimer = 0;
  const hold = () => hand.feed({ type: "hold", id: -1, x: 0, y: 0 });

  const placeOf = (/** @type {MouseEvent} */ event) => placeOn(canvas, event);
  /** Whether the pointer is on the picture, not on a button over it or beside it. @param {PointerEvent} event */
  const isOnCanvas = (event) => {
    const page = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    return page.elementFromPoint(event.clientX, event.clientY) === canvas;
  };
  /** @param {PointerEventLike["type"]} type */
  const onPointer = (type) => (/** @type {PointerEvent} */ event) => {
    const isTouch = event.pointerType === "touch";
    const place = placeOf(event);
    const isOutside = type === "cancel" || (hand.gesture.phase !== "idle" && !isOnCanvas(event));
    const last = aim.pointer;
    const isTap = type === "up" && hand.gesture.phase === "tap";
    aim.setPointer(isOutside || (isTouch && type === "up" && !isTap) ? null : place);
    if (type !== "move") clearTimeout(holdTimer);
    if (aim.isKeyboard) aim.showCross(false);
    if (type === "down") {
      canvas.setPointerCapture(event.pointerId);
      hand.points.press = view.pointAt(place);
      if (event.pointerType !== "mouse") holdTimer = window.setTimeout(hold, HOLD_MS);
    }
    if (type === "move" && hand.gesture.phase === "idle") {
      aim.point();
      aim.stretch();
      return;
    }
    const hit = isOutside ? null : view.hitAt(place);
    const { pointerId: id, button, shiftKey: shift } = event;
    const brush = event.metaKey || (event.ctrlKey && !IS_MAC); // there, Ctrl makes a right click
    const kind = { id, button, shift, brush, isOutside, isTouch, isFree: event.altKey };
    const isStroke = hand.gesture.stroke || hand.gesture.phase === "paint";
    if (type === "move" && isStroke && last && !isOutside) {
      for (const between of placesBetween(last, place, BRUSH_STEP))
        hand.feed({ type, ...kind, ...between, hit: view.hitAt(between) });
    }
    hand.feed({ type, ...kind, ...place, hit });
    if (hand.gesture.phase === "link") aim.stretch(place);
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
    if (DOWN.includes(hand.gesture.phase)) hand.letGo();
  });
  on("pointerleave", (/** @type {PointerEvent} */ event) => {
    if (event.pointerType === "touch") return; // what was tapped stays pointed at
    aim.setPointer(null);
    aim.point();
    aim.stretch();
  });
  on("dblclick", (/** @type {MouseEvent} */ event) => {
    if (model.get("mode") === "navigate") view.recentre(placeOf(event));
  });
  signal.addEventListener("abort", () => clearTimeout(holdTimer));
}

/**
 * Places that a pointer has passed between two events, so far from each other.
 * @param {Place} from
 * @param {Place} to
 * @param {number} step
 */
export function* placesBetween(from, to, step) {
  const n = Math.ceil(Math.hypot(to.x - from.x, to.y - from.y) / step);
  for (let i = 1; i < n; i++) {
    yield { x: from.x + (i / n) * (to.x - from.x), y: from.y + (i / n) * (to.y - from.y) };
  }
}
