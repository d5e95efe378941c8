/** What a press or a drag does in edit mode. */

import { element, iconButton } from "./elements.js";

/** @typedef {import("../input/gestures.js").Tool} Tool */

/** @param {(tool: Tool) => void} setTool */
export function createToolbox(setTool) {
  const buttons = {
    merge: iconButton("merge", "Merge", "drag, or click twice"),
    brush: iconButton("brush", "Brush", "G, or Ctrl + drag"),
    cut: iconButton("cut", "Cut", "C"),
    paint: iconButton("paint", "Paint", "M"),
    lasso: iconButton("lasso", "Lasso", "Q"),
    slice: iconButton("slice", "Slice", "Z"),
  };
  const tools = /** @type {Array<keyof typeof buttons>} */ (Object.keys(buttons));
  let shown = /** @type {Tool} */ ("merge");
  for (const tool of tools) {
    buttons[tool].onclick = () => tool !== shown && setTool(tool);
    buttons[tool].setAttribute("aria-pressed", String(tool === shown));
  }
  const group = element(
    "div",
    { class: "sw-group", role: "group", "aria-label": "Tool", hidden: "" },
    Object.values(buttons),
  );
  return {
    element: group,

    /** @param {Tool} tool */
    show(tool) {
      shown = tool;
      for (const name of tools) buttons[name].setAttribute("aria-pressed", String(name === tool));
    },
  };
}
