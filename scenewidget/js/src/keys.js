/** The keyboard: which key does what, also as the help overlay lists it. */

/**
 * @typedef {{ kind: "orbit" | "pan", dx: number, dy: number }
 *   | { kind: "zoom", factor: number }
 *   | { kind: "look", from: "here" | "above" | "start" }
 *   | { kind: "toggle", what: "outlines" | "back_faces" | "help" }
 *   | { kind: "level", index: number }
 *   | { kind: "undo" | "redo" | "escape" }} Command
 */

/** @type {Array<[string, string]>} */
export const NAVIGATION_HELP = [
  ["Drag", "orbit"],
  ["Right drag, Shift + drag", "pan"],
  ["Wheel", "zoom to the pointer"],
  ["Double click", "turn around this point"],
  ["← ↑ → ↓", "orbit; with Shift, pan"],
  ["+  −", "zoom"],
  ["F", "fit the scan into the view"],
  ["T", "look from above"],
  ["R", "back to the first view"],
  ["1 – 9", "level"],
  ["O", "outlines on or off"],
  ["B", "back faces on or off"],
  ["?", "this help"],
];

/** @type {Array<[string, string]>} */
export const EDIT_HELP = [
  ["Drag from part to part", "merge"],
  ["Click, then click", "merge, too"],
  ["Right click", "split"],
  ["Drag on the background, Shift + drag", "orbit"],
  ["Esc", "let go"],
  ["Ctrl + Z", "undo"],
  ["Ctrl + Shift + Z", "redo"],
];

/** @type {Record<string, [number, number]>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const STEP = 24; // pixels of a drag that a key stands for

/** @type {Record<string, Command>} */
const COMMANDS = {
  "+": { kind: "zoom", factor: 0.85 },
  "=": { kind: "zoom", factor: 0.85 },
  "-": { kind: "zoom", factor: 1 / 0.85 },
  f: { kind: "look", from: "here" },
  t: { kind: "look", from: "above" },
  r: { kind: "look", from: "start" },
  o: { kind: "toggle", what: "outlines" },
  b: { kind: "toggle", what: "back_faces" },
  "?": { kind: "toggle", what: "help" },
  escape: { kind: "escape" },
};

/**
 * The command of a key press; null for keys that are not ours, which the host may have.
 * @param {{ key: string, shiftKey: boolean, ctrlKey: boolean, metaKey: boolean, altKey: boolean }} event
 * @param {"navigate" | "edit"} mode
 * @returns {Command | null}
 */
export function command(event, mode) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) {
    if (mode !== "edit") return null;
    if (key === "z") return { kind: event.shiftKey ? "redo" : "undo" };
    return key === "y" ? { kind: "redo" } : null;
  }
  if (key in ARROWS) {
    const [dx, dy] = ARROWS[key];
    return { kind: event.shiftKey ? "pan" : "orbit", dx: dx * STEP, dy: dy * STEP };
  }
  if (/^[1-9]$/.test(key)) return { kind: "level", index: Number(key) - 1 };
  return COMMANDS[key.toLowerCase()] ?? null;
}
