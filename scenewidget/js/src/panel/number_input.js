/** A box for a number, typed with a decimal point or a comma; arrow keys step it. */

import { element } from "./elements.js";

const SPACES = /[\s\u00a0\u202f'’_]/g; // that part thousands

/**
 * The number that a text stands for; NaN if it stands for none. A single comma is a decimal one.
 * @param {string} text
 */
export function numberOf(text) {
  const plain = text.trim().replace(SPACES, "").replace("−", "-");
  if (/^[+-]?\d{1,3}(,\d{3})+(\.\d*)?$/.test(plain) && (plain.includes(".") || /,.*,/.test(plain)))
    return Number(plain.replaceAll(",", ""));
  if (/^[+-]?\d{1,3}(\.\d{3})+(,\d*)?$/.test(plain) && (plain.includes(",") || /\..*\./.test(plain)))
    return Number(plain.replaceAll(".", "").replace(",", "."));
  const point = plain.replace(",", ".");
  return /\d/.test(point) && /^[+-]?\d*\.?\d*(e[+-]?\d+)?$/i.test(point) ? Number(point) : Number.NaN;
}

/**
 * The next number on a grid of steps.
 * @param {number} value
 * @param {{ step?: number, low?: number, high?: number }} grid
 * @param {1 | -1} way
 */
export function stepped(value, { step = 1, low = -Infinity, high = Infinity }, way) {
  const decimals = (String(step).split(".")[1] ?? "").length;
  const next = (Math.round(value / step) + way) * step;
  return Math.min(high, Math.max(low, Number(next.toFixed(decimals))));
}

/**
 * @param {{ step?: number, low?: number, high?: number }} grid
 * @param {Record<string, string>} attributes
 * @param {() => void} onStep  an arrow key has changed it
 */
export function createNumberInput(grid, attributes, onStep) {
  const input = element("input", {
    ...{ type: "text", role: "spinbutton", inputmode: "decimal", autocomplete: "off", spellcheck: "false" },
    ...attributes,
  });
  if (grid.low !== undefined) input.setAttribute("aria-valuemin", String(grid.low));
  if (grid.high !== undefined) input.setAttribute("aria-valuemax", String(grid.high));
  input.addEventListener("keydown", (event) => {
    const way = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : null;
    const value = numberOf(input.value);
    if (way === null || Number.isNaN(value)) return;
    event.preventDefault(); // the caret stays
    input.value = String(stepped(value, grid, way));
    onStep();
  });
  return input;
}
