/**
 * What pointer movements mean: a state machine without a page.
 *
 * `step(gesture, event, mode, tool)` gives the next gesture and the actions to take. In "navigate" a left drag
 * orbits; in "edit" it uses the tool, and orbits if it starts on the background or with Shift. A right drag
 * pans in both; a right click splits in "edit".
 *
 * Tools: "merge" puts the part that a drag starts on onto the part it ends on; "brush" puts all parts that it
 * passes over onto the one it starts on; "cut" divides the segment between the ends; "paint" takes the faces
 * under a round brush; "lasso" draws an outline or sets its corners; "slice" and "measure" take points, and a
 * drag turns the room meanwhile. Instead of a drag, the ends of a merge or a cut can be clicked one after the
 * other. "measure" works in "navigate" as well.
 *
 * A finger orbits in both modes, two pan and zoom; a tap is a click, a long press a right click. With the brush
 * in hand one finger paints. A pen is a mouse whose long press is a right click.
 */

/** Pixels of travel up to which a press and release is a click. */
export const CLICK_TRAVEL = 4;
const TAP_TRAVEL = 10; // a finger is less steady

/** Parts that one stroke gathers. */
const MOST_GATHERED = 5000;

/** @typedef {"navigate" | "edit"} Mode */
/** @typedef {"merge" | "brush" | "cut" | "paint" | "lasso" | "slice" | "measure"} Tool */
/** @typedef {import("../labels/partition.js").Hit} Hit */
/** @typedef {import("../scene/camera.js").Place} Place */

/**
 * @typedef {object} PointerEventLike
 * @property {"down" | "move" | "up" | "cancel" | "hold" | "choose" | "finish" | "group"} type  hold: the pointer
 *   has been down in its place for a while; choose: what a click does, by key; finish, group: merge what the brush
 *   has gathered, or make it parts of one thing
 * @property {number} id
 * @property {number} x
 * @property {number} y
 * @property {number} [button]  0 left, 1 middle, 2 right
 * @property {boolean} [shift]
 * @property {boolean} [brush]  a key is held that makes any tool a brush
 * @property {boolean} [isFree]  a key is held that frees the round brush from the surface
 * @property {boolean} [isTouch]
 * @property {boolean} [isOutside]  the pointer has left the picture
 * @property {Hit | null} [hit]  what lies under the pointer; null outside the picture and on the background
 */

/**
 * @typedef {object} Gesture
 * @property {"idle" | "orbit" | "pan" | "pinch" | "tap" | "press" | "link" | "aside" | "dab" | "brush" | "paint" | "trace"} phase  tap: a finger
 *   before it leaves its place; press, link: left button on a part before and after leaving its place; dab, brush: the same with the brush; aside: right
 *   button before it moves; paint: the round brush is down; trace: an outline is being drawn
 * @property {Record<number, Place>} pointers  those that are down, where they were last
 * @property {Place} start
 * @property {boolean} hasLeft  whether a line that is being drawn has left its place
 * @property {Hit | null} from  part that the press began on
 * @property {Hit | null} picked  part that a click has picked; the next click merges it
 * @property {Stroke | null} stroke  what the brush has gathered so far
 */

/** @typedef {{ onto: Hit, gathered: Hit[] }} Stroke */

/**
 * @typedef {import("../scene/viewer.js").Movement
 *   | { kind: "click" | "split" | "paint", face: number }
 *   | { kind: "mark" | "close" }
 *   | { kind: "merge", face: number | number[], onto: number }
 *   | { kind: "group", face: number[], onto: number }
 *   | { kind: "cut", face: number, onto: number }} Action
 */

/** @type {Gesture} */
export const IDLE = {
  ...{ phase: /** @type {"idle"} */ ("idle"), pointers: {}, start: { x: 0, y: 0 } },
  ...{ hasLeft: false, from: null, picked: null, stroke: null },
};

/**
 * @param {Gesture} gesture
 * @param {PointerEventLike} event
 * @param {Mode} mode
 * @param {Tool} [tool]
 * @returns {[Gesture, Action[]]}
 */
export function step(gesture, event, mode, tool = "merge") {
  switch (event.type) {
    case "down":
      return [press(gesture, event, mode, tool), []];
    case "move":
      return move(gesture, event);
    case "up":
      return release(gesture, event, mode, tool);
    case "hold":
      if (mode !== "edit" || !gesture.from || isDrawn(tool, mode)) return [gesture, []];
      if (!["tap", "press"].includes(gesture.phase)) return [gesture, []];
      return [IDLE, [{ kind: "split", face: gesture.from.face }]];
    case "choose":
      if (gesture.phase === "idle" && isDrawn(tool, mode)) return [IDLE, [{ kind: "mark" }]];
      if (gesture.phase !== "idle" || !event.hit) return [gesture, []];
      if (tool === "paint") return [IDLE, [{ kind: "paint", face: event.hit.face }]];
      if (tool !== "brush") return choose(gesture, event.hit, tool);
      return [{ ...IDLE, stroke: gather(gesture.stroke, event.hit) }, []];
    case "finish":
      if (isDrawn(tool, mode)) return gesture.phase === "idle" ? [IDLE, [{ kind: "close" }]] : [gesture, []];
      return gesture.phase === "idle" ? [IDLE, merged(gesture.stroke)] : [gesture, []];
    case "group":
      return gesture.phase === "idle" ? [IDLE, merged(gesture.stroke, "group")] : [gesture, []];
    default:
      return [IDLE, []];
  }
}

/**
 * @param {Gesture} gesture
 * @param {PointerEventLike} event
 * @param {Mode} mode
 * @param {Tool} tool
 * @returns {Gesture}
 */
function press(gesture, event, mode, tool) {
  const place = { x: event.x, y: event.y };
  const pointers = { ...gesture.pointers, [event.id]: place };
  const next = { ...gesture, pointers, start: place, from: event.hit ?? null };
  if (Object.keys(pointers).length > 1)
    return { ...next, phase: event.isTouch ? "pinch" : gesture.phase, from: null };
  const isEdit = mode === "edit" && event.hit;
  if (event.button === 2) return { ...next, phase: isEdit ? "aside" : "pan" };
  if (event.button === 1) return { ...next, phase: "pan" };
  if (isDrawn(tool, mode) && !event.shift)
    return { ...next, picked: null, stroke: null, hasLeft: false, phase: tool === "lasso" ? "trace" : "tap" };
  if (isEdit && !event.shift && tool === "paint")
    return { ...next, phase: "paint", picked: null, stroke: null };
  if (isEdit && event.hit && !event.shift && (tool === "brush" || event.brush))
    return { ...next, phase: "dab", picked: null, stroke: gather(gesture.stroke, event.hit) };
  if (event.isTouch) return { ...next, phase: "tap" };
  if (isEdit) return { ...next, stroke: null, phase: event.shift ? "orbit" : "press" };
  return { ...next, phase: event.shift && mode === "navigate" ? "pan" : "orbit" };
}

/**
 * @param {Gesture} gesture
 * @param {PointerEventLike} event
 * @returns {[Gesture, Action[]]}
 */
function move(gesture, event) {
  const last = gesture.pointers[event.id];
  if (!last) return [gesture, []];
  const [dx, dy] = [event.x - last.x, event.y - last.y];
  const next = { ...gesture, pointers: { ...gesture.pointers, [event.id]: { x: event.x, y: event.y } } };
  const hasLeft = travel(gesture.start, event) >= (event.isTouch ? TAP_TRAVEL : CLICK_TRAVEL);
  switch (gesture.phase) {
    case "orbit":
    case "pan":
      return [next, [{ kind: gesture.phase, dx, dy }]];
    case "pinch":
      return [next, pinch(gesture.pointers, next.pointers)];
    case "tap":
      return hasLeft ? begin(next, event, "orbit") : [next, []];
    case "press":
      return [hasLeft ? { ...next, phase: "link", picked: null } : next, []];
    case "dab":
    case "brush":
      return [
        {
          ...next,
          phase: hasLeft ? "brush" : gesture.phase,
          stroke: event.hit ? gather(gesture.stroke, event.hit) : gesture.stroke,
        },
        [],
      ];
    case "aside":
      return hasLeft ? begin(next, event, "pan") : [next, []];
    case "trace":
      return [{ ...next, hasLeft: gesture.hasLeft || travel(gesture.start, event) >= TAP_TRAVEL }, []];
    default:
      return [next, []];
  }
}

/** Whether a tool sets points or draws lines over the picture. @param {Tool} tool @param {Mode} mode */
export function isDrawn(tool, mode) {
  return tool === "measure" || (mode === "edit" && (tool === "lasso" || tool === "slice"));
}

/**
 * A movement that begins once the pointer has left its place, from there.
 * @param {Gesture} gesture
 * @param {Place} place
 * @param {"orbit" | "pan"} kind
 * @returns {[Gesture, Action[]]}
 */
function begin(gesture, { x, y }, kind) {
  return [{ ...gesture, phase: kind }, [{ kind, dx: x - gesture.start.x, dy: y - gesture.start.y }]];
}

/**
 * @param {Gesture} gesture
 * @param {PointerEventLike} event
 * @param {Mode} mode
 * @param {Tool} tool
 * @returns {[Gesture, Action[]]}
 */
function release(gesture, event, mode, tool) {
  if (!gesture.pointers[event.id]) return [gesture, []];
  const { [event.id]: _, ...pointers } = gesture.pointers;
  if (Object.keys(pointers).length > 0) {
    return [{ ...gesture, pointers, phase: gesture.phase === "pinch" ? "orbit" : gesture.phase }, []];
  }
  if (gesture.phase === "trace" || (gesture.phase === "tap" && isDrawn(tool, mode))) {
    const isMark = gesture.phase === "tap" || !gesture.hasLeft; // an outline may end where it began
    return [IDLE, event.isOutside && isMark ? [] : [{ kind: isMark ? "mark" : "close" }]];
  }
  const rest = { ...IDLE, picked: gesture.picked, stroke: gesture.stroke };
  const { phase, from } = gesture;
  const to = event.hit ?? null;
  if (phase === "link" && from) {
    return [IDLE, to ? joined(from, to, tool) : []];
  }
  if (from && (phase === "press" || (phase === "tap" && mode === "edit"))) return choose(gesture, from, tool);
  if (phase === "brush") return [IDLE, event.isOutside ? [] : merged(gesture.stroke)];
  if (phase === "paint" && from) return [IDLE, [{ kind: "paint", face: from.face }]];
  if (phase === "aside" && from) return [IDLE, [{ kind: "split", face: from.face }]];
  const isClick = phase === "orbit" && !event.isTouch && travel(gesture.start, event) < CLICK_TRAVEL;
  if (isClick || phase === "tap") {
    return [IDLE, from ? [{ kind: "click", face: from.face }] : []];
  }
  return [rest, []];
}

/**
 * The first part chosen is picked, the second one is what it merges with; the same one again lets go.
 * @param {Gesture} gesture
 * @param {Hit} hit
 * @param {Tool} tool
 * @returns {[Gesture, Action[]]}
 */
function choose({ picked }, hit, tool) {
  if (!picked) return [{ ...IDLE, picked: hit }, [{ kind: "click", face: hit.face }]];
  return [IDLE, joined(picked, hit, tool)];
}

/**
 * What becomes of two ends.
 * @param {Hit} from
 * @param {Hit} to
 * @param {Tool} tool
 * @returns {Action[]}
 */
function joined(from, to, tool) {
  const ends = { face: from.face, onto: to.face };
  if (tool === "cut") return from.face === to.face ? [] : [{ kind: "cut", ...ends }];
  return isSame(from, to) ? [] : [{ kind: "merge", ...ends }];
}

/**
 * A stroke with one more part, the first one being what the others are put onto.
 * @param {Stroke | null} stroke
 * @param {Hit} hit
 * @returns {Stroke}
 */
function gather(stroke, hit) {
  if (!stroke) return { onto: hit, gathered: [] };
  const isKnown = isSame(stroke.onto, hit) || stroke.gathered.some((known) => isSame(known, hit));
  if (isKnown || stroke.gathered.length >= MOST_GATHERED) return stroke;
  return { ...stroke, gathered: [...stroke.gathered, hit] };
}

/** @param {Stroke | null} stroke @param {"merge" | "group"} kind @returns {Action[]} */
function merged(stroke, kind = "merge") {
  if (!stroke || stroke.gathered.length === 0) return [];
  return [{ kind, face: stroke.gathered.map(({ face }) => face), onto: stroke.onto.face }];
}

/** @param {Hit} a @param {Hit} b */
function isSame(a, b) {
  return a.part === b.part && a.segment === b.segment;
}

/**
 * Two fingers: their middle moves the picture, their distance zooms it.
 * @param {Record<number, Place>} before
 * @param {Record<number, Place>} after
 * @returns {Action[]}
 */
function pinch(before, after) {
  const ids = Object.keys(after).map(Number).slice(0, 2);
  const [a, b, c, d] = [before[ids[0]], before[ids[1]], after[ids[0]], after[ids[1]]];
  if (!a || !b || !c || !d) return [];
  const [x, y] = [(c.x + d.x) / 2, (c.y + d.y) / 2];
  const factor = travel(a, b) / Math.max(1, travel(c, d));
  return [
    { kind: "pan", dx: x - (a.x + b.x) / 2, dy: y - (a.y + b.y) / 2 },
    { kind: "zoom", factor, x, y },
  ];
}

/** @param {Place} a @param {Place} b */
function travel(a, b) {
  return Math.hypot(a.x - b.x, a.y - b.y);
}
