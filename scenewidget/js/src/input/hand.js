/** What is in hand: the tool, the gesture that is being made with it, and what becomes of it. */

import { NONE } from "../labels/partition.js";
import { FINAL } from "../labels/prediction.js";
import { IDLE, isDrawn, step } from "./gestures.js";
import { createLasso } from "./lasso.js";
import { createMeasure } from "./measure.js";
import { createPaint } from "./paint.js";
import { createSlice } from "./slice.js";
import { createToolOptions } from "./tool_options.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */
/** @typedef {import("./gestures.js").Action} Action */
/** @typedef {import("./gestures.js").Hit} Hit */
/** @typedef {import("./gestures.js").PointerEventLike} PointerEventLike */
/** @typedef {import("./gestures.js").Tool} Tool */

/** @typedef {ReturnType<typeof createHand>} Hand */

/** @param {import("./messages.js").Around} around */
export function createHand({ model, view, segments, root, send, on }) {
  let gesture = IDLE;
  /** @type {Tool} */
  let tool = "merge";
  /** Where on the surface the last press was, and where the picked part was taken. */
  const points = {
    press: /** @type {Vec3 | null} */ (null),
    picked: /** @type {Vec3 | null} */ (null),
    seeds: /** @type {[Vec3, Vec3] | null} */ (null), // of a cut that Python is about
  };

  const options = createToolOptions({ send, on });
  const paint = createPaint({ view, segments, options, send });
  /** Tools that draw over the picture. */
  const lasso = createLasso({ view, segments, options, send });
  const slice = createSlice({ view, segments, options, send });
  const measure = createMeasure({ view, send });

  /** What the tool in hand draws. */
  function drawn() {
    if (!isDrawn(tool, model.get("mode"))) return null;
    return tool === "lasso" ? lasso : tool === "slice" ? slice : measure;
  }

  /** @param {PointerEventLike} event */
  function feed(event) {
    const before = gesture;
    const [next, actions] = step(gesture, event, model.get("mode"), tool);
    gesture = next;
    if (next.picked && next.picked !== before.picked) points.picked = points.press;
    root.dataset.gesture = next.phase;
    if (next.stroke?.gathered.length !== before.stroke?.gathered.length) sketch();
    const isPaint = next.phase === "paint" || actions.some(({ kind }) => kind === "paint");
    if (!isPaint && before.phase === "paint") paint.drop();
    if (isPaint && event.type !== "hold") paint.add(event, next.from?.face ?? event.hit?.face ?? null);
    if (next.phase === "trace") drawn()?.trace(event);
    else if (event.type === "cancel" || (before.phase === "trace" && actions.length === 0)) drawn()?.drop();
    for (const action of actions) {
      if (action.kind === "cut") {
        const start = before.phase === "link" ? points.press : points.picked;
        const end = before.phase === "link" ? view.pointAt(event) : points.press;
        points.seeds = start && end && [start, end];
      }
      if (action.kind === "mark") drawn()?.mark(event);
      else if (action.kind === "close") drawn()?.finish();
      else act(action);
    }
    send({ kind: "hand" });
  }

  /** @param {Action} action */
  function act(action) {
    const { level } = segments;
    switch (action.kind) {
      case "merge":
        send({ kind: "edit", edit: { kind: "merge", face: action.face, onto_face: action.onto, level } });
        break;
      case "group":
        send({ kind: "edit", edit: { kind: "group", face: action.face, onto_face: action.onto } });
        break;
      case "split":
        send({ kind: "edit", edit: { kind: "split", face: action.face, level } });
        break;
      case "cut":
        send({ kind: "edit", edit: { kind: "cut", face_a: action.face, face_b: action.onto } });
        break;
      case "paint":
        paint.finish();
        break;
      case "click":
        model.send({ kind: "click", face: action.face });
        break;
      case "mark":
      case "close":
        break;
      default:
        send(action);
    }
  }

  /** Show what the brush has gathered as if it had been merged already. */
  function sketch() {
    const { stroke } = gesture;
    const faces = stroke?.gathered.map(({ face }) => face) ?? [];
    segments.sketch =
      stroke && faces.length > 0
        ? { kind: "merge", face: faces, onto_face: stroke.onto.face, level: segments.level }
        : null;
    segments.read();
    root.dataset.segments = String(segments.count);
  }

  const letGo = () => feed({ type: "cancel", id: -1, x: 0, y: 0 });

  /** Take up a tool, or put it down if it is in hand already. @param {Tool} wanted */
  function setTool(wanted) {
    letGo();
    tool = wanted === tool ? "merge" : wanted;
    root.dataset.tool = tool;
    if (["paint", "lasso", "slice"].includes(tool)) view.prepareSurface();
    send({ kind: "hand" });
    send({ kind: "tool_taken", tool });
  }

  /** Let go of what is in hand, then of the tool; whether there was anything. */
  function back() {
    const isIdle =
      gesture.phase === "idle" && !gesture.picked && !gesture.stroke && (drawn()?.isEmpty ?? true);
    if (isIdle && tool === "merge") return false;
    if (isIdle) setTool("merge");
    else letGo();
    return true;
  }

  /** A hit as it is after levels or segments have changed. @param {Hit | null} hit */
  function renewed(hit) {
    const part = hit ? view.partOf(hit.face) : NONE;
    return hit && part !== NONE ? { face: hit.face, part, segment: view.segmentOf(hit.face) } : null;
  }

  /** Pick a segment whole where that can be, else frame it. @param {number} segment */
  function chooseSegment(segment) {
    const face = view.faceOf(segment);
    if (face === null) return;
    if (model.get("mode") !== "edit" || segments.level !== FINAL || segment === NONE) {
      view.lookAt(face);
      return;
    }
    points.press = null;
    feed({ type: "choose", id: -1, x: 0, y: 0, hit: { face, part: view.partOf(face), segment } });
  }

  on({
    tool: ({ tool: wanted }) => setTool(wanted),
    resize({ way }) {
      options.resize(tool, way);
    },
    let_go: letGo,
    back,
    moving: () => drawn()?.renew(),
    rested: () => drawn()?.renew(),
    options: () => drawn()?.renew(),
    pointed: ({ face, at }) => drawn()?.point(face, at),
    finish: () => feed({ type: "finish", id: -1, x: 0, y: 0 }),
    group: () => feed({ type: "group", id: -1, x: 0, y: 0 }),
    choose_segment: ({ segment }) => chooseSegment(segment),
  });

  return {
    get gesture() {
      return gesture;
    },
    get tool() {
      return tool;
    },
    /** What to do next with the tool that draws, in words; null with any other. */
    get drawingHint() {
      return drawn()?.hint() ?? null;
    },
    points,
    options,
    feed,
    letGo,
    back,
    setTool,

    /** Levels or segments have changed. */
    renew() {
      const { from, picked, stroke } = gesture;
      const onto = renewed(stroke?.onto ?? null);
      gesture = {
        ...gesture,
        from: renewed(from),
        picked: renewed(picked),
        stroke: stroke && onto && { ...stroke, onto },
      };
      send({ kind: "hand" });
    },

    /** The picked part and where it was taken, if there is one. */
    picked() {
      const { picked } = gesture;
      return picked && { face: picked.face, place: view.placeOf(points.picked ?? [0, 0, 0]) };
    },
  };
}
