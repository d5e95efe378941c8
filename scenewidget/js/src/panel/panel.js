/** The page around the picture: toolbar, status line, progress, errors, help. Text is always set as text. */

import { AIM_HELP, helpSections } from "../input/keys.js";
import { isWhole } from "../scene/section.js";
import { createKeeping } from "./autosave.js";
import { element, iconButton, textButton } from "./elements.js";
import { createHistory } from "./history.js";
import { createLegend } from "./legend.js";
import { createNaming } from "./name_form.js";
import { createRubber } from "./rubber_band.js";
import { createSectionPanel } from "./section_panel.js";
import { createSegmentList } from "./segment_list.js";
import { createToolbox } from "./toolbox.js";

/**
 * @typedef {object} Actions
 * @property {(from: "here" | "above" | "start") => void} look
 * @property {(isInside: boolean) => void} goInside
 * @property {import("./section_panel.js").SectionActions} section
 * @property {(name: string, value: unknown) => void} set  a piece of the model's state
 * @property {() => void} cancel
 * @property {(kind: "undo" | "redo") => void} walk  through the history
 * @property {(what: import("../input/keys.js").PartAction) => void} act  on the picked part
 * @property {(n: number) => void} goTo  undo or redo until so many edits are done
 * @property {() => void} letGo  of the picked part, or of the tool
 * @property {(tool: import("../input/gestures.js").Tool) => void} setTool
 * @property {() => void} finish  merge what the brush has gathered
 * @property {() => void} showAll
 * @property {() => void} save
 * @property {(notice: string, action: string) => void} choose  a button of a notice was pressed
 * @property {import("./segment_list.js").ListActions} list
 */

/**
 * @typedef {object} PanelState
 * @property {string} colorBy
 * @property {string} [errorsTitle]  what errors are shown against; "" = none can be shown
 * @property {boolean} hasScan
 * @property {boolean} hasValues
 * @property {string} valuesTitle
 * @property {boolean} hasPartition
 * @property {boolean} hasConfidence
 * @property {string[]} levels
 * @property {string} level
 * @property {boolean} outlines
 * @property {boolean} backFaces
 * @property {boolean} segmentList  whether it is open
 * @property {import("../scene/section.js").Range[]} section
 * @property {number[]} lengths  of the scan, that the section is part of
 * @property {number} mixing
 * @property {boolean} busy
 * @property {number} progress
 * @property {string} status
 * @property {string} error
 * @property {"navigate" | "edit"} mode
 * @property {boolean} editable  whether it offers to edit
 * @property {string | null} undo  name of the step; "" = a step without a name, null = none
 * @property {string | null} redo
 * @property {number} pending  edits that Python hasn't answered
 * @property {import("./autosave.js").SaveState} saveState
 * @property {string} saveNote
 * @property {import("./autosave.js").Notice[]} notices
 * @property {number} nHidden  segments that aren't drawn
 * @property {string[]} vocabulary
 * @property {string[]} quickNames
 * @property {boolean} historyShown
 * @property {import("./history.js").Step[]} history
 * @property {number} nDone  edits that are done
 * @property {string} summary  shown at rest, with the status
 * @property {import("./legend.js").Legend | null} legend  of the colours shown
 */

const REMARK_MS = 5000;
const PENDING_MS = 300; // an answer that takes longer is told to be on its way

/**
 * @param {HTMLElement} host
 * @param {Actions} actions
 */
export function createPanel(host, actions) {
  const canvas = element("canvas", { class: "sw-canvas" });
  const fit = iconButton("fit", "Fit", "Shift + F");
  const above = iconButton("above", "Top view", "T");
  const start = iconButton("start", "Reset view", "R");
  const inside = iconButton("inside", "First-person view", "V");
  const section = iconButton("section", "Section", "X");
  const outlines = iconButton("outlines", "Outlines", "O");
  const backFaces = iconButton("backFaces", "Back faces", "B");
  const segmentList = iconButton("list", "List of segments", "L");
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
  const toolbox = createToolbox(actions.setTool);
  const keeping = createKeeping(actions);
  const toHistory = iconButton("history", "History", "U");
  const history = element("div", { class: "sw-group" }, [
    ...[undo, redo, toHistory, keeping.button, keeping.word],
  ]);
  const steps = createHistory({
    goTo: actions.goTo,
    close: () => {
      actions.set("history_shown", false);
      root.focus({ preventScroll: true });
    },
  });
  const showAll = textButton("Show all", "Show what is hidden (Shift + H)");
  const hiddenGroup = element("div", { class: "sw-group", hidden: "" }, [showAll]);
  const tools = element("div", { class: "sw-tools", role: "toolbar", "aria-label": "View" }, [
    element("div", { class: "sw-group" }, [field("Colour", colorBy), mixing, levelField]),
    hiddenGroup,
    modes,
    toolbox.element,
    history,
    element("div", { class: "sw-group" }, [outlines, backFaces, section]),
    element("div", { class: "sw-group" }, [fit, above, inside, start]),
    element("div", { class: "sw-group" }, [segmentList, help]),
  ]);

  const swatch = element("span", { class: "sw-swatch", hidden: "" });
  const statusText = element("span", { class: "sw-status-text" });
  const remarkText = element("span", { class: "sw-remark", role: "status" });
  const pendingText = element("span", { class: "sw-pending", hidden: "" });
  const status = element("div", { class: "sw-status" }, [pendingText, swatch, remarkText, statusText]);

  const bar = element("div", { class: "sw-bar" });
  const track = element(
    "div",
    { class: "sw-track", role: "progressbar", "aria-label": "Progress", hidden: "" },
    [bar],
  );
  const stage = element("span", { class: "sw-stage-name" });
  const cancel = textButton("Cancel");
  const busy = element("div", { class: "sw-busy", role: "status", hidden: "" }, [stage, cancel]);

  const errorText = element("div", { class: "sw-error-text" });
  const dismiss = textButton("Dismiss");
  const error = element("div", { class: "sw-error", role: "alert", hidden: "" }, [errorText, dismiss]);

  const helpList = element("div", { class: "sw-keys" });
  const closeHelp = iconButton("close", "Close help", "?");
  const helpCard = element(
    "div",
    { class: "sw-help", role: "dialog", "aria-label": "Keys and gestures", hidden: "" },
    [
      element("div", { class: "sw-help-head" }, [element("b", {}, ["Keys and gestures"]), closeHelp]),
      helpList,
      element("div", { class: "sw-aim-help" }, [AIM_HELP]),
    ],
  );

  const legend = createLegend();

  /** @type {Array<[string, import("../input/keys.js").PartAction, string]>} */
  const actsOn = [
    ["Split", "split", "Split this part off (S)"],
    ["Name", "name", "Name this segment (N)"],
    ["Hide", "hide", "Hide this segment (H)"],
    ["Isolate", "isolate", "Hide all other segments (I)"],
    ["Frame", "frame", "Fit this segment into the view (F)"],
  ];
  const pickedText = element("span", { class: "sw-picked-text", role: "status" });
  const letGo = iconButton("close", "Let go", "Esc");
  const finish = textButton("Merge them", "Merge what is gathered (Shift + Enter)");
  const actButtons = actsOn.map(([name, what, title]) => {
    const button = textButton(name, title);
    button.onclick = () => actions.act(what);
    return button;
  });
  const pickedBar = element(
    "div",
    { class: "sw-picked", role: "toolbar", "aria-label": "Picked part", hidden: "" },
    [pickedText, ...actButtons, finish, letGo],
  );
  const dock = element("div", { class: "sw-dock" }, [keeping.bars, error, busy, pickedBar]);
  const naming = createNaming(() => root.focus({ preventScroll: true }));
  const rubber = createRubber();
  const list = createSegmentList(actions.list);
  const sectionPanel = createSectionPanel(actions.section);
  const aim = element("div", { class: "sw-aim", "aria-hidden": "true", hidden: "" });

  const preview = element("div", { class: "sw-preview", role: "status", hidden: "" }, ["Preview"]);

  const root = element(
    "div",
    {
      class: "scenewidget",
      tabindex: "0",
      role: "application",
      "aria-label": "3D view of a scan; press ? for the keys",
      "data-jp-suppress-context-menu": "",
      "data-lm-suppress-shortcuts": "true",
      "data-ready": "false",
      "data-busy": "false",
      "data-segments": "0",
      "data-hovered": "",
      "data-picked": "",
      "data-target": "",
      "data-pending": "0",
      "data-hidden": "0",
      "data-moving": "true",
    },
    [
      element("div", { class: "sw-stage" }, [
        ...[canvas, preview, rubber.element, aim, tools, legend.element, status, track],
        ...[steps.element, sectionPanel.element, dock, naming.element, helpCard],
      ]),
      list.element,
    ],
  );
  host.append(root);
  const below = () => `${tools.offsetTop + tools.offsetHeight + 6}px`;
  new ResizeObserver(() => root.style.setProperty("--sw-below-tools", below())).observe(tools);

  const showHelp = (/** @type {boolean} */ isShown) => {
    helpCard.hidden = !isShown;
    help.setAttribute("aria-expanded", String(isShown));
    if (isShown) closeHelp.focus({ preventScroll: true });
    else root.focus({ preventScroll: true });
  };
  const hasTouch = matchMedia("(any-pointer: coarse)").matches;
  let listed = "";
  const showKeys = (/** @type {PanelState} */ { editable, mode }) => {
    if (listed === `${editable} ${mode}`) return;
    listed = `${editable} ${mode}`;
    const row = (/** @type {import("../input/keys.js").Row} */ [keys, what]) =>
      element("div", { class: "sw-key" }, [element("b", {}, [keys]), element("span", {}, [what])]);
    helpList.replaceChildren(
      ...helpSections({ editable, mode, hasTouch }).flatMap(({ title, rows }) => {
        const [first, ...rest] = rows.map(row);
        const head = element("div", { class: "sw-keys-title" }, [title]);
        return [element("div", { class: "sw-key-first" }, [head, first]), ...rest];
      }),
    );
  };
  fit.onclick = () => actions.look("here");
  above.onclick = () => actions.look("above");
  start.onclick = () => actions.look("start");
  help.onclick = () => showHelp(Boolean(helpCard.hidden));
  closeHelp.onclick = () => showHelp(false);
  outlines.onclick = () => actions.set("outlines", !isPressed(outlines));
  backFaces.onclick = () => actions.set("back_faces", !isPressed(backFaces));
  inside.onclick = () => actions.goInside(!isPressed(inside));
  section.onclick = () => sectionPanel.show(!sectionPanel.isShown());
  segmentList.onclick = () => actions.set("segment_list", !isPressed(segmentList));
  colorBy.onchange = () => actions.set("color_by", colorBy.value);
  level.onchange = () => actions.set("level", level.value);
  look.onclick = () => actions.set("mode", "navigate");
  edit.onclick = () => actions.set("mode", "edit");
  toHistory.onclick = () => actions.set("history_shown", !isPressed(toHistory));
  undo.onclick = () => actions.walk("undo");
  redo.onclick = () => actions.walk("redo");
  showAll.onclick = () => actions.showAll();
  letGo.onclick = () => actions.letGo();
  finish.onclick = () => actions.finish();
  mixing.oninput = () => actions.set("color_mix", Number(mixing.value));
  cancel.onclick = () => {
    cancel.disabled = true;
    actions.cancel();
  };
  dismiss.onclick = () => actions.set("error", "");

  let summary = "";
  let said = "";
  let hover = /** @type {{ text: string, color: string | null } | null} */ (null);
  let remarkTimer = 0;
  let pendingTimer = 0;
  const showStatus = () => {
    const rest = [summary, remarkText.textContent ? "" : said].filter(Boolean).join("  ·  ");
    const text = hover?.text ?? rest;
    if (statusText.textContent !== text) statusText.textContent = text; // even the same text would be drawn anew
    swatch.hidden = !hover?.color;
    if (hover?.color) swatch.style.background = hover.color;
  };

  return {
    root,
    canvas,
    isHelpShown: () => !helpCard.hidden,
    showHelp,
    rubber,
    naming,
    aim,
    preview,
    dock,
    list,
    section: sectionPanel,

    /** @param {boolean} isInside  whether one stands in the room */
    showInside(isInside) {
      if (root.dataset.inside === String(isInside)) return;
      root.dataset.inside = String(isInside);
      inside.setAttribute("aria-pressed", String(isInside));
    },

    /** Say something for a few seconds, beside whatever else is shown. @param {string} text */
    remark(text) {
      clearTimeout(remarkTimer);
      remarkText.textContent = text;
      remarkTimer = text ? window.setTimeout(() => this.remark(""), REMARK_MS) : 0;
      showStatus();
    },

    /** @param {import("../input/gestures.js").Tool} tool */
    showTool(tool) {
      toolbox.show(tool);
    },

    /**
     * Offer what can be done with the picked part, or with what a brush has gathered; or say how a tool goes.
     * @param {string | null} text
     * @param {"part" | "stroke" | "hint"} [kind]
     */
    showPicked(text, kind = "part") {
      for (const button of actButtons) button.hidden = kind !== "part";
      finish.hidden = kind !== "stroke";
      pickedBar.dataset.kind = kind;
      if (pickedText.textContent !== (text ?? "")) pickedText.textContent = text ?? "";
      if (text === null && pickedBar.contains(document.activeElement)) root.focus({ preventScroll: true });
      pickedBar.hidden = text === null;
    },

    /** @param {PanelState} state */
    update(state) {
      const isPainted = state.colorBy !== "scan" && state.colorBy !== "shaded";
      options(colorBy, state.colorBy, [
        ["segments", "Segments", state.hasPartition],
        ["parts", "Parts", state.hasPartition && state.levels.length > 0],
        ["confidence", "Confidence", state.hasConfidence],
        ["errors", "Errors", Boolean(state.errorsTitle)],
        ["values", state.valuesTitle || "Values", state.hasValues],
        ["normals", "Normals", true],
        ["scan", "Scan", state.hasScan],
        ["shaded", "Plain", true],
      ]);
      options(
        level,
        state.level,
        state.levels.map((name) => [name, capitalized(name), true]),
      );
      levelField.hidden = state.levels.length === 0;
      mixing.hidden = !isPainted;
      mixing.value = String(state.mixing);
      outlines.setAttribute("aria-pressed", String(state.outlines));
      backFaces.setAttribute("aria-pressed", String(state.backFaces));
      section.setAttribute("aria-pressed", String(!isWhole(state.section)));
      sectionPanel.update(state.section, state.lengths);
      segmentList.hidden = !state.hasPartition;
      segmentList.setAttribute("aria-pressed", String(state.segmentList));
      list.show(state.segmentList && state.hasPartition);

      track.hidden = busy.hidden = !state.busy;
      track.classList.toggle("sw-swinging", state.progress < 0);
      bar.style.width = state.progress < 0 ? "" : `${100 * state.progress}%`;
      if (state.progress >= 0) track.setAttribute("aria-valuenow", String(Math.round(100 * state.progress)));
      else track.removeAttribute("aria-valuenow");
      stage.textContent = [
        state.status || "Working",
        state.progress > 0 ? `${Math.round(100 * state.progress)} %` : "",
      ].join("  ");
      if (!state.busy) cancel.disabled = false;
      root.dataset.busy = String(state.busy);

      errorText.textContent = state.error;
      error.hidden = state.error === "";

      legend.show(state.legend);
      modes.hidden = history.hidden = !state.editable;
      toolbox.element.hidden = !state.editable || state.mode !== "edit";
      look.setAttribute("aria-pressed", String(state.mode === "navigate"));
      edit.setAttribute("aria-pressed", String(state.mode === "edit"));
      offer(undo, "Undo", "Ctrl + Z", state.undo);
      offer(redo, "Redo", "Ctrl + Shift + Z", state.redo);
      hiddenGroup.hidden = state.nHidden === 0;
      root.dataset.hidden = String(state.nHidden);
      naming.offer(state.vocabulary, state.quickNames);
      const hasHistory = state.editable && state.historyShown;
      toHistory.setAttribute("aria-pressed", String(hasHistory));
      steps.update(hasHistory, state.history, state.nDone);
      keeping.update(state);

      root.dataset.pending = String(state.pending);
      pendingText.textContent = state.pending === 1 ? "1 edit pending" : `${state.pending} edits pending`;
      if (state.pending === 0) {
        clearTimeout(pendingTimer);
        pendingTimer = 0;
        pendingText.hidden = true;
      } else if (pendingTimer === 0) {
        pendingTimer = window.setTimeout(() => {
          pendingText.hidden = false;
        }, PENDING_MS);
      }

      showKeys(state);
      summary = state.summary;
      said = state.busy ? "" : state.status;
      showStatus();
    },

    /** @param {{ text: string, color: string | null } | null} description */
    showHover(description) {
      hover = description;
      showStatus();
    },

    /** Say why there is no picture. @param {string} message */
    showFailure(message) {
      root.replaceChildren(element("div", { class: "sw-failure", role: "alert" }, [message]));
    },
  };
}

/**
 * @param {HTMLButtonElement} button
 * @param {string} name
 * @param {string} key
 * @param {string | null} step  that it would take; null = there is none
 */
function offer(button, name, key, step) {
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
 * @param {Array<[string, string, boolean]>} choices  value, text, whether it is offered
 */
function options(select, value, choices) {
  const offered = choices.filter(([, , isOffered]) => isOffered);
  const signature = JSON.stringify(offered);
  if (select.dataset.choices !== signature) {
    select.dataset.choices = signature;
    select.replaceChildren(...offered.map(([name, text]) => element("option", { value: name }, [text])));
  }
  select.value = value;
}

/** @param {HTMLElement} button */
function isPressed(button) {
  return button.getAttribute("aria-pressed") === "true";
}

/** @param {string} text */
function capitalized(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
