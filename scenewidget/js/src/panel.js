/** The page around the picture: toolbar, status line, progress, errors, help. Text is always set as text. */

import { EDIT_HELP, NAVIGATION_HELP } from "./keys.js";

/**
 * @typedef {object} Actions
 * @property {(from: "here" | "above" | "start") => void} look
 * @property {(name: string, value: unknown) => void} set  a piece of the model's state
 * @property {() => void} cancel
 */

/**
 * @typedef {object} PanelState
 * @property {string} colorBy
 * @property {boolean} hasScan
 * @property {boolean} hasValues
 * @property {boolean} hasPartition
 * @property {string[]} levels
 * @property {string} level
 * @property {boolean} outlines
 * @property {boolean} backFaces
 * @property {number} mixing
 * @property {boolean} busy
 * @property {number} progress
 * @property {string} status
 * @property {string} error
 * @property {"navigate" | "edit"} mode
 * @property {string} summary  shown at rest
 * @property {{ title?: string, low?: number, high?: number, colors: string[] } | null} legend
 */

const ICONS = {
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  above: "M8 2 14 5 8 8 2 5ZM2 8.2l6 3 6-3M2 11.2l6 3 6-3",
  start: "M2.5 7.5 8 2.5l5.5 5M4.2 6.5v6.8h7.6V6.5",
  outlines: "M2.5 3.5h4l2 4.5-2 4.5h-4ZM9.5 3.5h4v9h-4l2-4.5Z",
  backFaces: "M2.5 5 8 2.3 13.5 5v6L8 13.7 2.5 11ZM2.5 5 8 7.8 13.5 5M8 7.8v5.9",
};

/**
 * @param {HTMLElement} host
 * @param {Actions} actions
 */
export function createPanel(host, actions) {
  const canvas = element("canvas", { class: "sw-canvas" });
  const iconButton = (
    /** @type {keyof typeof ICONS} */ icon,
    /** @type {string} */ name,
    /** @type {string} */ key,
  ) =>
    element("button", { class: "sw-button", type: "button", "aria-label": name, title: `${name} (${key})` }, [
      iconOf(icon),
    ]);
  const fit = iconButton("fit", "Fit", "F");
  const above = iconButton("above", "Top view", "T");
  const start = iconButton("start", "Reset view", "R");
  const outlines = iconButton("outlines", "Outlines", "O");
  const backFaces = iconButton("backFaces", "Back faces", "B");
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
  const tools = element("div", { class: "sw-tools", role: "toolbar", "aria-label": "View" }, [
    element("div", { class: "sw-group" }, [field("Colour", colorBy), mixing, levelField]),
    element("div", { class: "sw-group" }, [outlines, backFaces]),
    element("div", { class: "sw-group" }, [fit, above, start]),
    element("div", { class: "sw-group" }, [help]),
  ]);

  const swatch = element("span", { class: "sw-swatch", hidden: "" });
  const statusText = element("span", { class: "sw-status-text" });
  const status = element("div", { class: "sw-status" }, [swatch, statusText]);

  const bar = element("div", { class: "sw-bar" });
  const track = element(
    "div",
    { class: "sw-track", role: "progressbar", "aria-label": "Progress", hidden: "" },
    [bar],
  );
  const stage = element("span", { class: "sw-stage" });
  const cancel = element("button", { class: "sw-text-button", type: "button" }, ["Cancel"]);
  const busy = element("div", { class: "sw-busy", role: "status", hidden: "" }, [stage, cancel]);

  const errorText = element("div", { class: "sw-error-text" });
  const dismiss = element("button", { class: "sw-text-button", type: "button" }, ["Dismiss"]);
  const error = element("div", { class: "sw-error", role: "alert", hidden: "" }, [errorText, dismiss]);

  const helpList = element("div", { class: "sw-keys" });
  const closeHelp = element("button", { class: "sw-text-button", type: "button" }, ["Close"]);
  const helpCard = element(
    "div",
    { class: "sw-help", role: "dialog", "aria-label": "Keys and gestures", hidden: "" },
    [helpList, closeHelp],
  );

  const legendTitle = element("div", { class: "sw-legend-title" });
  const legendBar = element("div", { class: "sw-legend-bar" });
  const legendLow = element("span");
  const legendHigh = element("span");
  const legend = element("div", { class: "sw-legend", hidden: "" }, [
    legendTitle,
    legendBar,
    element("div", { class: "sw-legend-ends" }, [legendLow, legendHigh]),
  ]);

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
      "data-moving": "true",
    },
    [canvas, tools, legend, status, track, busy, error, helpCard],
  );
  host.append(root);

  const showHelp = (/** @type {boolean} */ isShown) => {
    helpCard.hidden = !isShown;
    help.setAttribute("aria-expanded", String(isShown));
    if (isShown) closeHelp.focus({ preventScroll: true });
    else root.focus({ preventScroll: true });
  };
  fit.onclick = () => actions.look("here");
  above.onclick = () => actions.look("above");
  start.onclick = () => actions.look("start");
  help.onclick = () => showHelp(Boolean(helpCard.hidden));
  closeHelp.onclick = () => showHelp(false);
  outlines.onclick = () => actions.set("outlines", !isPressed(outlines));
  backFaces.onclick = () => actions.set("back_faces", !isPressed(backFaces));
  colorBy.onchange = () => actions.set("color_by", colorBy.value);
  level.onchange = () => actions.set("level", level.value);
  mixing.oninput = () => actions.set("color_mix", Number(mixing.value));
  cancel.onclick = () => {
    cancel.disabled = true;
    actions.cancel();
  };
  dismiss.onclick = () => actions.set("error", "");

  let summary = "";
  let hover = /** @type {{ text: string, color: string | null } | null} */ (null);
  const showStatus = () => {
    const text = hover?.text ?? summary;
    if (statusText.textContent !== text) statusText.textContent = text; // even the same text would be drawn anew
    swatch.hidden = !hover?.color;
    if (hover?.color) swatch.style.background = hover.color;
  };

  return {
    root,
    canvas,
    isHelpShown: () => !helpCard.hidden,
    showHelp,

    /** @param {PanelState} state */
    update(state) {
      const isPainted =
        state.colorBy === "segments" || state.colorBy === "parts" || state.colorBy === "values";
      options(colorBy, state.colorBy, [
        ["segments", "Segments", state.hasPartition],
        ["parts", "Parts", state.hasPartition && state.levels.length > 0],
        ["values", state.legend?.title || "Values", state.hasValues],
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

      legend.hidden = state.colorBy !== "values" || !state.legend;
      if (state.legend) {
        legendTitle.textContent = state.legend.title ?? "";
        legendBar.style.background = `linear-gradient(to right, ${state.legend.colors.join(", ")})`;
        legendLow.textContent = numberText(state.legend.low ?? 0);
        legendHigh.textContent = numberText(state.legend.high ?? 1);
      }
      const keys = state.mode === "edit" ? [...EDIT_HELP, ...NAVIGATION_HELP.slice(1)] : NAVIGATION_HELP;
      helpList.replaceChildren(
        ...keys.flatMap(([key, what]) => [element("b", {}, [key]), element("span", {}, [what])]),
      );
      summary = state.summary;
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
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string>} [attributes]
 * @param {Array<Node | string>} [children]
 * @returns {HTMLElementTagNameMap[Tag]}
 */
function element(tag, attributes = {}, children = []) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/** @param {keyof typeof ICONS} name */
function iconOf(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
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

/** @param {number} value */
function numberText(value) {
  return Number(value.toPrecision(3)).toLocaleString("en", { maximumSignificantDigits: 3 });
}
