/** Where people point, by pointer, by key or from elsewhere, and what is shown of it. */

import { NONE } from "../labels/partition.js";
import { heldOf, highlightOf, isCutting } from "./highlight.js";
import { hintOf } from "./hints.js";
import { radiusAt } from "./paint.js";

/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {ReturnType<typeof createAim>} Aim */

const POINTING = ["idle", "tap", "press", "link", "dab", "brush", "paint", "trace"]; // phases of a gesture that aim at something

/**
 * @param {import("./messages.js").Around & {
 *   hand: import("./hand.js").Hand,
 *   cutPreview: ReturnType<typeof import("./cut_preview.js").createCutPreview>,
 * }} around
 */
export function createAim({ model, view, segments, root, hand, cutPreview, send, on, signal }) {
  /** Where the pointer is; null when it is elsewhere. @type {Place | null} */
  let pointer = null;
  /** Whether keys were used last: without a pointer they aim at the middle. */
  let isKeyboard = false;
  /** @type {number | null} */
  let hoveredFace = null;
  /** Face that a linked view points at. @type {number | null} */
  let twin = null;
  /** Segment that the list points at. @type {number | null} */
  let listed = null;
  /** @type {{ face: number, onto: number } | null} */
  let suggested = null;

  /** Where keys act: under the pointer, or in the middle. @returns {Place | null} */
  function place() {
    return pointer ?? (isKeyboard ? { x: view.size.width / 2, y: view.size.height / 2 } : null);
  }

  /** Show what lies under the pointer. @param {boolean} [isForced]  even if it is the same face as before */
  function point(isForced = false) {
    const at = place();
    const { gesture, tool } = hand;
    const isPointing = POINTING.includes(gesture.phase);
    const own = at && isPointing ? view.faceAt(at) : null;
    const face = own ?? (at || view.isMoving ? null : twin);
    if (face === hoveredFace && !isForced) return;
    if (face !== hoveredFace)
      send({ kind: "pointed", face: own, at: own === null || !at ? null : view.pointAt(at) });
    hoveredFace = face;
    const held = heldOf(gesture);
    if (!held || !isCutting({ gesture, tool })) cutPreview.aim(null, null);
    else if (!view.isMoving && isPointing) cutPreview.aim(held.face, face);
    const offcut = segments.offcut?.segment ?? null;
    const { joined, ...lit } = highlightOf({ gesture, tool, face, listed, suggested, offcut }, surface);
    view.setLook(lit);
    send({ kind: "marked", segment: face === null ? listed : view.segmentOf(face) });
    root.dataset.listed = said(listed ?? NONE);
    root.dataset.hovered = said(face === null ? NONE : view.partOf(face));
    root.dataset.picked = said(held ? held.part : NONE);
    root.dataset.target = said(joined);
    const words = face !== null && view.partition ? segments.descriptionOf(face) : null;
    const isTarget = words && joined !== NONE;
    send({ kind: "hover", words: isTarget ? { ...words, text: `Merge into ${words.text}` } : words });
    hint();
  }

  const surface = {
    partOf: (/** @type {number} */ face) => view.partOf(face),
    segmentOf: (/** @type {number} */ face) => view.segmentOf(face),
    isTarget: (/** @type {number} */ face, /** @type {number} */ onto) => segments.isTarget(face, onto),
  };

  /** Say what to do next with what is in hand. */
  function hint() {
    send({ kind: "hint", ...hintOf(hand, segments, cutPreview.isLooking) });
  }

  /** The outline of the round brush. */
  function ring() {
    const at = hand.tool === "paint" && model.get("mode") === "edit" ? place() : null;
    const radius = at && radiusAt(view, hand.options.current, at);
    send({ kind: "ring", place: radius === null ? null : at, radius: radius ?? 0 });
  }

  /** The line from the part being moved to the pointer. @param {Place | null} [tip] */
  function stretch(tip = place()) {
    const { gesture, points, tool } = hand;
    ring();
    const start = gesture.phase === "link" ? points.press : gesture.picked && points.picked;
    const isCut = segments.pending.operations.some(({ kind }) => kind === "cut");
    if (!isCut) points.seeds = null;
    if (!start && points.seeds) {
      const [from, to] = points.seeds.map((seed) => view.placeOf(seed));
      send({ kind: "line", from, to, isHeld: true });
      return;
    }
    const isHeld = view.look.target !== NONE || tool === "cut";
    send({ kind: "line", from: start && view.placeOf(start), to: tip, isHeld });
  }

  /** Whether keys act on the middle of the picture. @param {boolean} isShown */
  function showCross(isShown) {
    isKeyboard = isShown;
    send({ kind: "cross", isShown: isShown && pointer === null });
    point();
  }

  /** The face that keys act on: what is pointed at, else what is picked. @returns {number | null} */
  function target() {
    const at = place();
    return (at && view.faceAt(at)) ?? hand.picked()?.face ?? null;
  }

  on({
    moving: () => stretch(),
    rested() {
      point();
      stretch();
    },
    hand() {
      point(true);
      stretch();
    },
    options: ring,
    cut_sought() {
      if (hand.tool === "cut" && !hand.gesture.stroke) hint();
    },
    twin_pointed({ face }) {
      twin = face;
      point();
    },
    listed({ segment }) {
      if (segment === listed) return;
      listed = segment;
      point(true);
    },
    suggested({ edit }) {
      suggested = edit;
      point(true);
    },
    choose() {
      const at = place();
      hand.points.press = at && view.pointAt(at);
      if (at) hand.feed({ type: "choose", id: -1, ...at, hit: view.hitAt(at) });
    },
    part({ what }) {
      const face = target();
      if (face !== null) send({ kind: "act", what, face, place: place() });
      else if (what === "frame") view.lookFrom("here");
    },
    act_on_picked({ what }) {
      const picked = hand.picked();
      if (picked) send({ kind: "act", what, ...picked });
    },
    act_on_segment({ what, segment }) {
      const face = view.faceOf(segment);
      if (face !== null) send({ kind: "act", what, face, place: null });
    },
  });
  root.addEventListener("focusout", () => showCross(false), { signal });

  return {
    place,
    point,
    stretch,
    showCross,
    target,

    get pointer() {
      return pointer;
    },
    get isKeyboard() {
      return isKeyboard;
    },
    /** @param {Place | null} at */
    setPointer(at) {
      pointer = at;
    },
  };
}

/** A part or a segment for a data attribute. @param {number} number */
function said(number) {
  return number === NONE ? "" : String(number);
}
