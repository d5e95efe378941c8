/** How the tool in hand is set, in a row below the picture. */

import { FIRST_OPTIONS } from "../input/tool_options.js";
import { element, setPressed, textButton } from "./elements.js";
import { createNumberInput, numberOf } from "./number_input.js";

/** @typedef {import("../input/tool_options.js").ToolOptions} ToolOptions */

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  gives the keys back to the picture
 */
export function createToolOptionsBar(send, leave) {
  let options = FIRST_OPTIONS;
  const set = (/** @type {Partial<ToolOptions>} */ changes) => {
    send({ kind: "option", changes });
  };
  /**
   * A button that switches something on and off.
   * @param {string} name
   * @param {string} title
   * @param {(options: ToolOptions) => boolean} isOn
   * @param {(isOn: boolean) => Partial<ToolOptions>} changes
   */
  const toggle = (name, title, isOn, changes) => {
    const button = textButton(name, title);
    button.onclick = () => set(changes(!isOn(options)));
    return { button, update: () => setPressed(button, isOn(options)) };
  };

  const takesAway = toggle(
    "Take away",
    "Take faces from the segment that the stroke begins on, and give them to the one beside it",
    (now) => now.takesAway,
    (isOn) => ({ takesAway: isOn }),
  );
  const sticks = toggle(
    "Stick to surface",
    "Stop at creases and at edges between colours; with Alt held it doesn't",
    (now) => now.sticks,
    (isOn) => ({ sticks: isOn }),
  );
  const size = createNumberInput(
    { step: 1, low: 0.2, high: 200 },
    { class: "sw-size", "aria-label": "Brush radius", title: "Radius of the brush ([ and ])" },
    () => takeSize(),
  );
  const takeSize = () => {
    const value = numberOf(size.value);
    if (value > 0)
      set({ radius: { ...options.radius, [options.unit]: Math.min(200, Math.max(0.2, value)) } });
    else update();
  };
  size.onchange = takeSize;
  size.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    takeSize();
    leave();
  });
  const unit = element("select", { class: "sw-select", "aria-label": "Unit of the brush radius" }, [
    element("option", { value: "px" }, ["px"]),
    element("option", { value: "cm" }, ["cm"]),
  ]);
  unit.onchange = () => set({ unit: unit.value === "cm" ? "cm" : "px" });
  const brush = element("div", { class: "sw-options-group" }, [
    element("label", { class: "sw-field" }, [element("span", {}, ["Radius"]), size]),
    ...[unit, sticks.button, takesAway.button],
  ]);
  const isThrough = toggle(
    "Through",
    "Take what is behind as well, not only what is seen",
    (now) => now.isThrough,
    (isOn) => ({ isThrough: isOn }),
  );
  const isOfOne = toggle(
    "One segment",
    "Take faces of one segment alone: the one that has most within the outline",
    (now) => now.isOfOne,
    (isOn) => ({ isOfOne: isOn }),
  );
  const close = textButton("Close outline", "Close the outline (Shift + Enter)");
  close.onclick = () => send({ kind: "finish" });
  const lasso = element("div", { class: "sw-options-group" }, [...[isThrough.button, isOfOne.button, close]]);
  const byPoints = toggle(
    "Three points",
    "A plane through three points; the first one says which segment is cut",
    (now) => now.plane === "points",
    () => ({ plane: "points" }),
  );
  const byWall = toggle(
    "By a wall",
    "A plane along the wall, table or floor that the segment leans on",
    (now) => now.plane === "wall",
    () => ({ plane: "wall" }),
  );
  const offset = createNumberInput(
    { step: 0.5, low: -100, high: 100 },
    {
      class: "sw-size",
      "aria-label": "Centimetres in front of it",
      title: "Centimetres in front of it ([ and ])",
    },
    () => takeOffset(),
  );
  const takeOffset = () => {
    const value = numberOf(offset.value);
    if (Number.isFinite(value)) set({ offset: Math.min(100, Math.max(-100, value)) });
    else update();
  };
  offset.onchange = takeOffset;
  const gap = element("label", { class: "sw-field" }, [offset, element("span", {}, ["cm in front"])]);
  const slice = element("div", { class: "sw-options-group" }, [byPoints.button, byWall.button, gap]);
  /** @type {Partial<Record<import("../input/gestures.js").Tool, HTMLElement>>} */
  const groups = { paint: brush, lasso, slice };
  const bar = element(
    "div",
    { class: "sw-options", role: "toolbar", "aria-label": "Options of the tool", hidden: "" },
    Object.values(groups),
  );

  function update() {
    for (const { update: show } of [takesAway, sticks, isThrough, isOfOne, byPoints, byWall]) show();
    offset.value = String(options.offset);
    gap.hidden = options.plane !== "wall";
    size.value = String(options.radius[options.unit]);
    unit.value = options.unit;
  }
  update();

  return {
    element: bar,

    /** @param {import("../input/gestures.js").Tool} tool */
    showTool(tool) {
      bar.hidden = !(tool in groups);
      for (const [name, group] of Object.entries(groups)) group.hidden = name !== tool;
    },

    /** @param {ToolOptions} next */
    show(next) {
      options = next;
      update();
    },
  };
}
