/** What bars over the picture say when something is amiss. */

import { counted } from "../labels/description.js";

/**
 * @typedef {{ key: string, text: string, actions: Array<[string, string]>, asks?: string }} Notice
 *   asks: what a question is about; without it, something is amiss
 */

const LOST_MS = 8000; // an answer that takes longer may never come

/** When the kernel has gone. @type {Notice} */
export const GONE = {
  key: "gone",
  text: "The kernel is gone: looking works, editing doesn't. Run the cell again.",
  actions: [],
};

/** When the line to it is cut. @type {Notice} */
export const CUT_OFF = {
  key: "cut",
  text: "No connection to the kernel: looking works, editing doesn't until it is back.",
  actions: [],
};

/** When the browser has taken the picture's graphics context away. @type {Notice} */
export const ASIDE = {
  key: "aside",
  text: "The browser has put this picture aside, as it does when many 3D views are open.",
  actions: [["Draw it again", "again"]],
};

/**
 * When nothing tells which way is up: each axis turns the picture, until somebody says that it is right.
 * @type {Notice}
 */
export const UP = {
  key: "up",
  asks: "Which way is up",
  text: "Which way is up? The scan doesn't tell. Turn it until it stands.",
  actions: [
    ["+x", "x"],
    ["−x", "-x"],
    ["+y", "y"],
    ["−y", "-y"],
    ["+z", "z"],
    ["−z", "-z"],
    ["It stands", "drop"],
  ],
};

/**
 * When nobody answers edits.
 * @param {{ age: number, operations: unknown[] }} pending
 * @param {boolean} isLive
 * @returns {{ notices: Notice[], wait: number | null }}  wait: milliseconds after which to ask again
 */
export function lostEdits({ age, operations }, isLive) {
  if (operations.length === 0) return { notices: [], wait: null };
  if (age < LOST_MS && isLive) return { notices: [], wait: LOST_MS - age };
  const edits = counted(operations.length, "edit");
  const text = !isLive
    ? `The kernel is gone and has not answered ${edits}. Run the cell again: what was saved is offered there`
    : `No answer from the kernel to ${edits} yet. If it is busy, they will be done; if it was restarted, ` +
      "they are lost: run the cell again";
  return { notices: [{ key: "lost", text, actions: [["Take them back", "forget"]] }], wait: null };
}
