/** The keyboard: which key does what, also as the help overlay lists it. */

/** @typedef {"split" | "name" | "ungroup" | "hide" | "isolate" | "frame"} PartAction  done to the part under the pointer */

/**
 * @typedef {{ kind: "orbit" | "pan", dx: number, dy: number }
 *   | { kind: "zoom", factor: number }
 *   | { kind: "look", from: "here" | "above" | "start" }
 *   | { kind: "walk", way: import("../scene/walk.js").Way }
 *   | { kind: "toggle", what: "outlines" | "back_faces" | "boxes" | "segment_list" | "section" | "picture" | "ceiling" | "inside" | "help" | "history_shown" | "mode" }
 *   | { kind: "level" | "quick_name", index: number }
 *   | { kind: "part", what: PartAction }
 *   | { kind: "undo" | "redo" | "escape" | "choose" | "finish" | "show_all" | "save" }
 *   | { kind: "resize", way: 1 | -1 }
 *   | { kind: "tool", tool: import("./gestures.js").Tool }} Command
 */

/** @typedef {[keys: string, what: string]} Row */

/** @type {Row[]} */
const DRAG_WHILE_LOOKING = [
  ["Drag", "orbit"],
  ["Shift + drag, right drag", "pan"],
  ["Double click", "turn around this point"],
];

/** @type {Row[]} */
const DRAG_WHILE_EDITING = [
  ["Shift + drag, or on the background", "orbit"],
  ["Right drag", "pan"],
];

/** @type {Row[]} */
const LOOK = [
  ["Wheel; +  −", "zoom"],
  ["← ↑ → ↓", "orbit; with Shift, pan"],
  ["F", "frame the segment"],
  ["Shift + F", "fit the scan into the view"],
  ["T", "from above"],
  ["R", "back to the first view"],
  ["V", "stand in the room, and back"],
];

/** @type {Row[]} */
const SHOW = [
  ["1 – 3", "level of the parts"],
  ["H", "hide the segment"],
  ["I", "hide all others"],
  ["Shift + H", "show all"],
  ["X", "cut the scan open with a box"],
  ["Shift + X", "cut the ceiling off, and back"],
  ["O", "outlines"],
  ["B", "back faces"],
  ["Shift + B", "boxes of the segments"],
  ["L", "list of segments; in it ↑ ↓ F H I N"],
  ["D", "distance between two points"],
  ["P", "save the picture as a file"],
  ["?", "this help"],
];

/** Looking or editing, where one can edit. @type {Row[]} */
const EDITABLE = [
  ["E", "look or edit"],
  ["K", "next suggestion; Enter accepts, K skips"],
  ["Ctrl + S", "save everything in one file"],
];

/** @type {Row[]} */
const EDIT = [
  ["Drag from part to part", "merge"],
  ["Click, click; Enter, Enter", "merge, too"],
  ["Ctrl + drag, G", "brush: gather parts onto the first"],
  ["Ctrl + click; Shift + Enter", "gather one by one; merge them"],
  ["M", "paint: what a round brush covers, out of a segment or onto it"],
  ["[  ]", "smaller, larger brush; with Alt it leaves the surface"],
  ["Q", "lasso: draw around faces, or click from corner to corner"],
  ["Z", "slice: a plane by three points, or by a wall"],
  ["Right click, S", "split"],
  ["C", "cut: from one side to the other"],
  ["N", "name the segment"],
  ["4 – 9, 0", "give it this name at once"],
  ["Esc", "let go; put the tool down"],
  ["Ctrl + Z", "undo"],
  ["Ctrl + Shift + Z", "redo"],
  ["U", "history: click on a step to go there"],
];

/** @type {Row[]} */
const TOUCH = [
  ["One finger, two", "orbit; pan and zoom"],
  ["Tap, then tap", "pick a part, merge it"],
  ["Long press", "split"],
  ["One finger with the brush", "gather parts"],
];

/** Said before the first edit. */
export const FIRST_STEPS = "Drag a part onto another to merge  ·  right-click to split  ·  ? for help";
export const FIRST_TOUCHES = "Tap a part, then another to merge  ·  hold to split  ·  ? for help";

/** @type {Row[]} */
const INSIDE = [
  ["W A S D, ↑ ↓", "walk"],
  ["← →", "turn"],
  ["Page up, Page down", "rise, sink"],
  ["Drag", "look around"],
  ["Wheel", "go on along the view"],
  ["Double click", "go there"],
];

/** Keys act on what is under the pointer; without one, on what is in the middle. */
export const AIM_HELP =
  "Keys act on what is under the pointer; without a mouse, on what is in the middle of the picture.";

/**
 * What the help overlay lists.
 * @param {{ editable: boolean, mode: "navigate" | "edit", hasTouch?: boolean }} state
 * @returns {Array<{ title: string, rows: Row[] }>}
 */
export function helpSections({ editable, mode, hasTouch = false }) {
  const isEdit = mode === "edit";
  const sections = [
    { title: "By touch", rows: hasTouch ? TOUCH : [] },
    { title: "Edit", rows: [...(editable ? EDITABLE : []), ...(isEdit ? EDIT : [])] },
    { title: "Look", rows: [...(isEdit ? DRAG_WHILE_EDITING : DRAG_WHILE_LOOKING), ...LOOK] },
    { title: "Show", rows: SHOW },
    { title: "Standing in the room", rows: INSIDE },
  ];
  return sections.filter(({ rows }) => rows.length > 0);
}

/** Digits that give names: those above the levels, as they lie on the keyboard. */
export const QUICK_KEYS = ["4", "5", "6", "7", "8", "9", "0"];

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const STEP = 24; // pixels of a drag that a key stands for

/** @type {Record<string, Command>} */
const COMMANDS = {
  "+": { kind: "zoom", factor: 0.85 },
  "=": { kind: "zoom", factor: 0.85 },
  "-": { kind: "zoom", factor: 1 / 0.85 },
  e: { kind: "toggle", what: "mode" },
  f: { kind: "part", what: "frame" },
  h: { kind: "part", what: "hide" },
  i: { kind: "part", what: "isolate" },
  t: { kind: "look", from: "above" },
  r: { kind: "look", from: "start" },
  o: { kind: "toggle", what: "outlines" },
  b: { kind: "toggle", what: "back_faces" },
  l: { kind: "toggle", what: "segment_list" },
  v: { kind: "toggle", what: "inside" },
  x: { kind: "toggle", what: "section" },
  p: { kind: "toggle", what: "picture" },
  d: { kind: "tool", tool: "measure" },
  "?": { kind: "toggle", what: "help" },
  escape: { kind: "escape" },
};

/** @type {Record<string, Command>} */
const WITH_SHIFT = {
  f: { kind: "look", from: "here" },
  h: { kind: "show_all" },
  b: { kind: "toggle", what: "boxes" },
  x: { kind: "toggle", what: "ceiling" },
};

/** @type {Record<string, import("../scene/walk.js").Way>} */
const WAYS = {
  w: "forward",
  s: "back",
  a: "left",
  d: "right",
  arrowup: "forward",
  arrowdown: "back",
  arrowleft: "turn_left",
  arrowright: "turn_right",
  pageup: "up",
  pagedown: "down",
};

/** @type {Record<string, Command>} */
const EDIT_COMMANDS = {
  enter: { kind: "choose" },
  c: { kind: "tool", tool: "cut" },
  g: { kind: "tool", tool: "brush" },
  m: { kind: "tool", tool: "paint" },
  q: { kind: "tool", tool: "lasso" },
  z: { kind: "tool", tool: "slice" },
  n: { kind: "part", what: "name" },
  "[": { kind: "resize", way: -1 },
  "]": { kind: "resize", way: 1 },
  u: { kind: "toggle", what: "history_shown" },
  s: { kind: "part", what: "split" },
};

const BRACKETS = ["[", "]"];

/**
 * The command of a key press; null for keys that are not ours, which the host may have.
 * @param {{ key: string, shiftKey: boolean, ctrlKey: boolean, metaKey: boolean, altKey: boolean }} event
 * @param {"navigate" | "edit"} mode
 * @param {boolean} [isInside]  whether one stands in the room
 * @returns {Command | null}
 */
export function command(event, mode, isInside = false) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (mode === "edit" && BRACKETS.includes(key)) return EDIT_COMMANDS[key]; // with Alt on many keyboards
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) {
    if (key === "s" && !event.shiftKey) return { kind: "save" };
    if (mode !== "edit") return null;
    if (key === "z") return { kind: event.shiftKey ? "redo" : "undo" };
    return key === "y" ? { kind: "redo" } : null;
  }
  const way = wayOf(key);
  if (isInside && way && !event.shiftKey) return { kind: "walk", way };
  if (key in ARROWS) {
    const [dx, dy] = ARROWS[key];
    return { kind: event.shiftKey ? "pan" : "orbit", dx: dx * STEP, dy: dy * STEP };
  }
  if (mode === "edit" && QUICK_KEYS.includes(key))
    return { kind: "quick_name", index: QUICK_KEYS.indexOf(key) };
  if (/^[1-9]$/.test(key)) return { kind: "level", index: Number(key) - 1 };
  const name = key.toLowerCase();
  if (name === "enter" && event.shiftKey && mode === "edit") return { kind: "finish" };
  return (
    (event.shiftKey && WITH_SHIFT[name]) || (mode === "edit" && EDIT_COMMANDS[name]) || COMMANDS[name] || null
  );
}

/** Where a key leads while one stands in the room. @param {string} key */
export function wayOf(key) {
  return WAYS[key.toLowerCase()];
}
