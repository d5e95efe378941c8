/** The keyboard: which key does what, also as the help overlay lists it. */

/** @typedef {"split" | "name" | "hide" | "isolate" | "frame"} PartAction  done to the part under the pointer */

/**
 * @typedef {{ kind: "orbit" | "pan", dx: number, dy: number }
 *   | { kind: "zoom", factor: number }
 *   | { kind: "look", from: "here" | "above" | "start" }
 *   | { kind: "walk", way: import("./walk.js").Way }
 *   | { kind: "toggle", what: "outlines" | "back_faces" | "segment_list" | "section" | "ceiling" | "inside" | "help" | "history_shown" | "mode" }
 *   | { kind: "level" | "quick_name", index: number }
 *   | { kind: "part", what: PartAction }
 *   | { kind: "undo" | "redo" | "escape" | "choose" | "finish" | "show_all" | "save" }
 *   | { kind: "tool", tool: import("./gestures.js").Tool }} Command
 */

/** While looking, not editing. @type {Array<[string, string]>} */
export const LOOK_HELP = [
  ["Drag", "orbit"],
  ["Right drag, Shift + drag", "pan"],
  ["Double click", "turn around this point"],
];

/** While looking and while editing. @type {Array<[string, string]>} */
export const NAVIGATION_HELP = [
  ["Wheel", "zoom to the pointer"],
  ["← ↑ → ↓", "orbit; with Shift, pan"],
  ["+  −", "zoom"],
  ["F", "frame the segment under the pointer"],
  ["Shift + F", "fit the scan into the view"],
  ["T", "look from above"],
  ["R", "back to the first view"],
  ["V", "stand in the room, and back"],
  ["X", "cut the scan open with a box"],
  ["Shift + X", "cut the ceiling off, or show the whole scan"],
  ["1 – 3", "level"],
  ["H", "hide the segment under the pointer"],
  ["I", "hide all others"],
  ["Shift + H", "show all"],
  ["O", "outlines on or off"],
  ["B", "back faces on or off"],
  ["L", "list of segments; in it ↑ ↓ go on, F H I N act on the row"],
  ["?", "this help"],
];

/** While editing. @type {Array<[string, string]>} */
export const EDIT_HELP = [
  ["Drag from part to part", "merge"],
  ["Click, then click; Enter, then Enter", "merge, too"],
  ["Ctrl + drag, G", "brush: gather parts onto the first one"],
  ["Ctrl + click; Shift + Enter", "gather one by one; merge them"],
  ["Right click, S", "split"],
  ["C", "cut: click or drag from one side to the other"],
  ["N", "name the segment; its form lists the names of the keys 4 – 9, 0"],
  ["4 – 9, 0", "give it this name at once"],
  ["Drag on the background, Shift + drag", "orbit"],
  ["Right drag", "pan"],
  ["Esc", "let go; put the tool down"],
  ["Ctrl + Z", "undo"],
  ["Ctrl + Shift + Z", "redo"],
  ["U", "history: click on a step to go there"],
];

/** Looking or editing, where one can edit. @type {Array<[string, string]>} */
export const EDITABLE_HELP = [
  ["E", "look or edit"],
  ["K", "next suggestion; Enter accepts it, K skips it"],
  ["Ctrl + S", "save everything in one file now"],
];

/** While standing in the room. @type {Array<[string, string]>} */
export const WALK_HELP = [
  ["W A S D, ↑ ↓", "walk"],
  ["← →", "turn"],
  ["Page up, Page down", "rise, sink"],
  ["Drag (Shift + drag while editing)", "look around"],
  ["Wheel", "go on along the view"],
  ["Double click (not while editing)", "go there"],
  ["V", "back outside"],
];

/** Keys act on what is under the pointer; without one, on what is in the middle. */
export const AIM_HELP = "Without a mouse, all of this happens to what is in the middle of the picture.";

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
  "?": { kind: "toggle", what: "help" },
  escape: { kind: "escape" },
};

/** @type {Record<string, Command>} */
const WITH_SHIFT = {
  f: { kind: "look", from: "here" },
  h: { kind: "show_all" },
  x: { kind: "toggle", what: "ceiling" },
};

/** @type {Record<string, import("./walk.js").Way>} */
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
  n: { kind: "part", what: "name" },
  u: { kind: "toggle", what: "history_shown" },
  s: { kind: "part", what: "split" },
};

/**
 * The command of a key press; null for keys that are not ours, which the host may have.
 * @param {{ key: string, shiftKey: boolean, ctrlKey: boolean, metaKey: boolean, altKey: boolean }} event
 * @param {"navigate" | "edit"} mode
 * @param {boolean} [isInside]  whether one stands in the room
 * @returns {Command | null}
 */
export function command(event, mode, isInside = false) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
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
