/** The row of buttons over the picture: colours, modes and tools, history, views, help. */

import { isWhole } from "../scene/section.js";
import { element, iconButton, isPressed, setPressed, textButton } from "./elements.js";
import { createToolbox } from "./toolbox.js";

/** @typedef {import("./state.js").PanelState} PanelState */

const COLUMN = "column:"; // before the name of a column of the table of segments, among the ways of colouring

/**
 * @param {import("../input/messages.js").Send} send
 * @param {Pick<ReturnType<typeof import("./autosave.js").createAutosave>, "button" | "word">} autosave
 */
export function createToolbar(send, autosave) {
  const set = (/** @type {string} */ name, /** @type {unknown} */ value) =>
    send({ kind: "set", name, value });
  const fit = iconButton("fit", "Fit", "Shift + F");
  const above = iconButton("above", "Top view", "T");
  const start = iconButton("start", "Reset view", "R");
  const inside = iconButton("inside", "First-person view", "V");
  const section = iconButton("section", "Section", "X");
  const outlines = iconButton("outlines", "Outlines", "O");
  const backFaces = iconButton("backFaces", "Back faces", "B");
  const boxes = iconButton("boxes", "Boxes", "Shift + B");
  const segmentList = iconButton("list", "List of segments", "L");
  const picture = iconButton("picture", "Picture", "P");
  const measure = iconButton("measure", "Distance", "D");
  const help = element(
    "button",
    { class: "sw-button", type: "button", "aria-label": "Help", title: "Help (?)" },
    ["?"],
  );
  const colorBy = element("select", { class: "sw-select", "aria-label": "Colour by", title: "Colour by" });
  const level = element("select", {
    class: "sw-select",
    "aria-label": "Level",
    title: "Level of the parts to point at",
  });
  const mixing = element("input", {
    class: "sw-range",
    type: "range",
    min: "0",
    max: "1",
    step: "0.05",
    "aria-label": "Colour strength",
    title: "Colour strength",
  });
  const levelField = field("Level", level);
  const look = textButton("Look", "Look: dragging turns the room (E)");
  const edit = textButton("Edit", "Edit: drag a part onto another to merge, right-click to split (E)");
  const undo = iconButton("undo", "Undo", "Ctrl + Z");
  const redo = iconButton("redo", "Redo", "Ctrl + Shift + Z");
  const modes = element("div", { class: "sw-group sw-modes", role: "group", "aria-label": "Mode" }, [
    look,
    edit,
  ]);
  const toolbox = createToolbox((tool) => send({ kind: "tool", tool }));
  const toHistory = iconButton("history", "History", "U");
  const history = element("div", { class: "sw-group" }, [
    ...[undo, redo, toHistory, autosave.button, autosave.word],
  ]);
  // where room is scarce, what is seldom needed waits behind it
  const more = element(
    "button",
    { class: "sw-text-button sw-more", type: "button", "aria-expanded": "false", title: "More buttons" },
    ["More"],
  );
  for (const button of [outlines, backFaces, boxes]) button.classList.add("sw-seldom");
  const showAll = textButton("Show all", "Show what is hidden (Shift + H)");
  const hiddenGroup = element("div", { class: "sw-group", hidden: "" }, [showAll]);
  const bar = element("div", { class: "sw-tools", role: "toolbar", "aria-label": "View" }, [
    element("div", { class: "sw-group" }, [field("Colour", colorBy), mixing, levelField]),
    hiddenGroup,
    modes,
    toolbox.element,
    history,
    element("div", { class: "sw-group" }, [more, section, outlines, backFaces, boxes]),
    element("div", { class: "sw-group sw-seldom" }, [fit, above, inside, start]),
    element("div", { class: "sw-group sw-seldom" }, [segmentList, measure, picture, help]),
  ]);

  more.onclick = () => {
    const isOpen = more.getAttribute("aria-expanded") !== "true";
    more.setAttribute("aria-expanded", String(isOpen));
    bar.classList.toggle("sw-open", isOpen);
  };
  fit.onclick = () => send({ kind: "look", from: "here" });
  above.onclick = () => send({ kind: "look", from: "above" });
  start.onclick = () => send({ kind: "look", from: "start" });
  inside.onclick = () => send({ kind: "toggle", what: "inside" });
  help.onclick = () => send({ kind: "toggle", what: "help" });
  picture.onclick = () => send({ kind: "toggle", what: "picture" });
  measure.onclick = () => send({ kind: "tool", tool: "measure" });
  section.onclick = () => send({ kind: "toggle", what: "section" });
  outlines.onclick = () => set("outlines", !isPressed(outlines));
  backFaces.onclick = () => set("back_faces", !isPressed(backFaces));
  boxes.onclick = () => set("boxes", !isPressed(boxes));
  segmentList.onclick = () => set("segment_list", !isPressed(segmentList));
  toHistory.onclick = () => set("history_shown", !isPressed(toHistory));
  colorBy.onchange = () => {
    const column = colorBy.value.startsWith(COLUMN) ? colorBy.value.slice(COLUMN.length) : null;
    if (column === null) set("color_by", colorBy.value);
    else set("column", column);
  };
  level.onchange = () => set("level", level.value);
  mixing.oninput = () => set("color_mix", Number(mixing.value));
  look.onclick = () => set("mode", "navigate");
  edit.onclick = () => set("mode", "edit");
  undo.onclick = () => send({ kind: "undo" });
  redo.onclick = () => send({ kind: "redo" });
  showAll.onclick = () => send({ kind: "show_all" });

  return {
    element: bar,

    /** @param {import("../input/gestures.js").Tool} tool */
    showTool(tool) {
      toolbox.show(tool);
      setPressed(measure, tool === "measure");
    },

    /** @param {boolean} isInside  whether one stands in the room */
    showInside: (isInside) => setPressed(inside, isInside),

    /** @param {boolean} isShown */
    showHelp: (isShown) => help.setAttribute("aria-expanded", String(isShown)),

    /** @param {PanelState} state */
    update(state) {
      offerChoices(colorBy, state.column ? COLUMN + state.column : state.colorBy, colorings(state));
      offerChoices(
        level,
        state.level,
        state.levels.map((name) => [name, capitalized(name)]),
      );
      levelField.hidden = state.levels.length === 0;
      mixing.hidden = state.colorBy === "scan" || state.colorBy === "shaded";
      mixing.value = String(state.mixing);
      setPressed(outlines, state.outlines);
      setPressed(backFaces, state.backFaces);
      boxes.hidden = !state.hasPartition;
      setPressed(boxes, Boolean(state.boxes));
      setPressed(section, !isWhole(state.section));
      segmentList.hidden = !state.hasPartition;
      setPressed(segmentList, state.segmentList);
      modes.hidden = history.hidden = !state.editable;
      toolbox.element.hidden = !state.editable || state.mode !== "edit";
      setPressed(look, state.mode === "navigate");
      setPressed(edit, state.mode === "edit");
      offerStep(undo, "Undo", "Ctrl + Z", state.undo);
      offerStep(redo, "Redo", "Ctrl + Shift + Z", state.redo);
      hiddenGroup.hidden = state.nHidden === 0;
      setPressed(toHistory, state.editable && state.historyShown);
    },
  };
}

/**
 * The ways of colouring that make sense now: value and text.
 * @param {Pick<PanelState, "hasPartition" | "hasConfidence" | "hasValues" | "hasScan" | "levels" | "errorsTitle" | "offersBorders" | "valuesTitle" | "columns" | "column">} state
 */
export function colorings(state) {
  const all = /** @type {Array<[string, string, boolean]>} */ ([
    ["segments", "Segments", state.hasPartition],
    ["parts", "Parts", state.hasPartition && state.levels.length > 0],
    ["confidence", "Confidence", state.hasConfidence],
    ["borders", "Doubtful borders", Boolean(state.offersBorders)],
    ["errors", "Errors", Boolean(state.errorsTitle)],
    ["values", state.valuesTitle || "Values", state.hasValues && !state.column],
    ["normals", "Normals", true],
    ["scan", "Scan", state.hasScan],
    ["shaded", "Plain", true],
    ...(state.columns ?? []).map((name) => [COLUMN + name, capitalized(name), state.hasPartition]),
  ]);
  return all
    .filter(([, , isOffered]) => isOffered)
    .map(([value, text]) => /** @type {[string, string]} */ ([value, text]));
}

/**
 * @param {HTMLButtonElement} button
 * @param {string} name
 * @param {string} key
 * @param {string | null} step  that it would take; null = there is none
 */
function offerStep(button, name, key, step) {
  const isFocused = button.matches(":focus"); // a disabled button would swallow the keys
  button.disabled = step === null;
  if (button.disabled && isFocused)
    button.closest(/** @type {any} */ (".scenewidget"))?.focus({ preventScroll: true });
  button.title =
    step === null ? `Nothing to ${name.toLowerCase()}` : `${name}${step && `: ${step}`} (${key})`;
}

/** @param {string} name @param {HTMLElement} control */
function field(name, control) {
  return element("label", { class: "sw-field" }, [element("span", {}, [name]), control]);
}

/**
 * @param {HTMLSelectElement} select
 * @param {string} value
 * @param {Array<[string, string]>} offered  value, text
 */
function offerChoices(select, value, offered) {
  const signature = JSON.stringify(offered);
  if (select.dataset.choices !== signature) {
    select.dataset.choices = signature;
    const options = offered.map(([name, text]) => element("option", { value: name }, [text]));
    const ofTable = options.filter((option) => option.value.startsWith(COLUMN));
    const others = options.filter((option) => !ofTable.includes(option));
    const group = element("optgroup", { label: "Segments by" }, ofTable);
    select.replaceChildren(...others, ...(ofTable.length > 0 ? [group] : []));
  }
  select.value = value;
}

/** @param {string} text */
function capitalized(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
