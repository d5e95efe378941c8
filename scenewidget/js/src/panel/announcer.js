/** Tells those who don't see the picture what has happened to it. */

import { counted } from "../labels/description.js";
import { element } from "./elements.js";

/**
 * What is told of; `pending` are edits that Python hasn't answered, whose outcome may still change.
 * @typedef {Pick<import("./state.js").PanelState,
 *   "busy" | "mode" | "nSegments" | "nHidden" | "undo" | "redo" | "pending">} Told
 */

export function createAnnouncer() {
  const region = element("div", { class: "sw-unseen", role: "status", "aria-live": "polite" });
  /** @type {Told | null} */
  let last = null;
  return {
    element: region,

    /** @param {Told} state */
    update(state) {
      if (state.pending > 0) return;
      const words = last && changes(last, state);
      last = { ...state };
      if (words) region.textContent = words;
    },
  };
}

/**
 * What has changed, in words; "" if nothing that is worth telling.
 * @param {Told} before
 * @param {Told} after
 */
export function changes(before, after) {
  const segments = counted(after.nSegments, "segment");
  const said = [];
  if (before.mode !== after.mode) said.push(after.mode === "edit" ? "Editing" : "Looking");
  if (after.busy) {
    if (!before.busy) said.push("Computing");
  } else if (before.busy) said.push(`Done: ${segments}`);
  else if (before.undo !== after.undo || before.redo !== after.redo) {
    const isUndone = after.redo !== null && after.redo !== before.redo && after.redo === before.undo;
    const step = isUndone ? `Undone: ${after.redo}` : after.undo || "Changed";
    said.push(`${step}. ${segments}`);
  } else if (before.nSegments !== after.nSegments) said.push(segments);
  if (before.nHidden !== after.nHidden)
    said.push(after.nHidden > 0 ? `${counted(after.nHidden, "segment")} hidden` : "Everything shown");
  return said.join(". ");
}
