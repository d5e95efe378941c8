/** Pieces of the page. */

const CONTROLS = new Set(["button", "select", "input"]);
const ICONS = {
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  above: "M8 2 14 5 8 8 2 5ZM2 8.2l6 3 6-3M2 11.2l6 3 6-3",
  start: "M2.5 7.5 8 2.5l5.5 5M4.2 6.5v6.8h7.6V6.5",
  outlines: "M2.5 3.5h4l2 4.5-2 4.5h-4ZM9.5 3.5h4v9h-4l2-4.5Z",
  backFaces: "M2.5 5 8 2.3 13.5 5v6L8 13.7 2.5 11ZM2.5 5 8 7.8 13.5 5M8 7.8v5.9",
  boxes: "M2.5 5.5h8v8h-8ZM5.5 5.5v-3h8v8h-3M2.5 5.5l3-3M10.5 5.5l3-3M10.5 13.5l3-3",
  undo: "M6 3 2.8 6.2 6 9.4M3 6.2h6.2a3.6 3.6 0 0 1 0 7.2H6.5",
  redo: "M10 3l3.2 3.2L10 9.4M13 6.2H6.8a3.6 3.6 0 0 0 0 7.2h2.7",
  list: "M2.5 4h1M6 4h7.5M2.5 8h1M6 8h7.5M2.5 12h1M6 12h7.5",
  merge: "M2.5 5.5h4v5h-4ZM9.5 8h4M11.5 6l2 2-2 2M6.5 8h3",
  brush: "M13.2 2.8 7.6 8.4M5.8 8.2l2 2c.4 1.6-1 3.3-4.8 3.1.9-.8.7-1.6.9-2.7.2-1.2.9-2.2 1.9-2.4Z",
  cut: "M4.2 4.6a1.6 1.6 0 1 0 .01 0ZM4.2 8.6a1.6 1.6 0 1 0 .01 0ZM5.5 5.8 13.5 11.5M5.5 10.2 13.5 4.5",
  paint: "M8 3.2a4.8 4.8 0 1 1-.01 0M8 8v.01M8 .8v1.4M8 13.8v1.4M.8 8h1.4M13.8 8h1.4",
  lasso:
    "M8 2.5c3.3 0 5.7 1.6 5.7 3.8S11.3 10.2 8 10.2 2.3 8.5 2.3 6.3 4.7 2.5 8 2.5M5 9.8a1.5 1.5 0 1 0 .6 2.4c.9.9 0 1.5-1.1 1.8",
  slice: "M2.5 5.2 8 2.7l5.5 2.5v5.6L8 13.3l-5.5-2.5ZM1 12.8 15 3.2",
  measure: "M1.8 11 11 1.8 14.2 5 5 14.2ZM4.4 8.4l1.6 1.6M6.6 6.2l1 1M8.8 4l1.6 1.6",
  grow: "M8 2.5v3M8 10.5v3M2.5 8h3M10.5 8h3M6.7 3.8 8 2.5l1.3 1.3M6.7 12.2 8 13.5l1.3-1.3M3.8 6.7 2.5 8l1.3 1.3M12.2 6.7 13.5 8l-1.3 1.3",
  shrink:
    "M8 2v3.5M8 10.5V14M2 8h3.5M10.5 8H14M6.7 4.2 8 5.5l1.3-1.3M6.7 11.8 8 10.5l1.3 1.3M4.2 6.7 5.5 8 4.2 9.3M11.8 6.7 10.5 8l1.3 1.3",
  fillHoles: "M2.5 2.5h11v11h-11ZM8 5.6a2.4 2.4 0 1 1-.01 0M6.4 9.6 9.6 6.4",
  smooth: "M1.5 11.5l2-5 2 5 2-5M8.5 8.5c2-3.4 4-3.4 6 0",
  history: "M3 8a5.2 5.2 0 1 1 1.6 3.8M3 4.6V8h3.4M8.2 5.2v3.1l2.2 1.3",
  save: "M3 2.5h8l2.5 2.5v8.5h-11v-10ZM5.2 2.7v3.6h5V2.7M4.8 13.3V9h6.4v4.3",
  inside:
    "M8 2.2a1.7 1.7 0 1 1 0 3.4 1.7 1.7 0 0 1 0-3.4M5.2 10.2V8.6a2.8 2.8 0 0 1 5.6 0v1.6M6.6 10v3.8M9.4 10v3.8",
  section: "M2.5 6.5 8 4l5.5 2.5v5L8 14l-5.5-2.5ZM2.5 6.5 8 9l5.5-2.5M8 9v5M1.5 2.5h13",
  picture: "M2.5 4.8h2.6l1.2-1.8h3.4l1.2 1.8h2.6v8h-11ZM8 6.6a2.3 2.3 0 1 1 0 4.6 2.3 2.3 0 0 1 0-4.6",
  close: "M4 4l8 8M12 4l-8 8",
};

/**
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, string>} [attributes]
 * @param {Array<Node | string>} [children]
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, attributes = {}, children = []) {
  const node = document.createElement(tag);
  // JupyterLab looks for it from the focused element upwards, but asks each one for shortcuts first
  if (CONTROLS.has(tag)) node.setAttribute("data-lm-suppress-shortcuts", "true");
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/**
 * @param {keyof typeof ICONS} icon
 * @param {string} name
 * @param {string} key
 */
export function iconButton(icon, name, key) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", ICONS[icon]);
  svg.append(path);
  const attributes = { class: "sw-button", type: "button", "aria-label": name, title: `${name} (${key})` };
  return element("button", attributes, [svg]);
}

/** @param {string} name @param {string} [title] */
export function textButton(name, title) {
  const attributes = { class: "sw-text-button", type: "button", ...(title ? { title } : {}) };
  return element("button", attributes, [name]);
}

/** @param {HTMLElement} button */
export function isPressed(button) {
  return button.getAttribute("aria-pressed") === "true";
}

/** @param {HTMLElement} button @param {boolean} isOn */
export function setPressed(button, isOn) {
  button.setAttribute("aria-pressed", String(isOn));
}
