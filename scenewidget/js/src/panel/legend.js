/** What the colours mean: a bar from low to high, or a row of samples with their names. */

import { confidenceColor, UNLIKELY } from "../labels/confidence.js";
import { BORDER_COLORS, RIGHT_COLOR, WRONG_COLOR } from "../labels/face_values.js";
import { axisNames } from "../scene/upright.js";
import { readArray } from "../wire/wire.js";
import { element } from "./elements.js";

/**
 * @typedef {object} Legend
 * @property {string} title
 * @property {string[]} [colors]  along a bar
 * @property {[string, string]} [ends]  of the bar
 * @property {Array<[string, string]>} [samples]  colour and name
 */

const N_STOPS = 18;
/** Directions of the upright room, in pairs below each other. */
const DIRECTIONS = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
  [-1, 0, 0],
  [0, -1, 0],
  [0, 0, -1],
];

/**
 * The legend of what is shown; null if its colours need none.
 * @param {import("../wire/wire.js").Model} model
 * @returns {Legend | null}
 */
export function legendOf(model) {
  switch (model.get("color_by")) {
    case "values": {
      const colormap = readArray(model, "colormap");
      if (!colormap) return null;
      const { title = "", low = 0, high = 1 } = model.get("values_legend");
      const colors = [];
      for (let i = 0; i < 256; i += 15) colors.push(`rgb(${colormap.slice(3 * i, 3 * i + 3).join(" ")})`);
      return { title, colors, ends: [numberText(low), numberText(high)] };
    }
    case "confidence": {
      const at = (/** @type {number} */ i) => UNLIKELY + (i / (N_STOPS - 1)) * (1 - UNLIKELY);
      return {
        title: "Confidence",
        colors: Array.from({ length: N_STOPS }, (_, i) => `rgb(${confidenceColor(at(i)).join(" ")})`),
        ends: [`≤ ${UNLIKELY} unsure`, "1 sure"],
      };
    }
    case "borders": {
      const at = (/** @type {number} */ i) => `rgb(${BORDER_COLORS.slice(3 * i, 3 * i + 3).join(" ")})`;
      return {
        title: "Borders between",
        colors: Array.from({ length: N_STOPS }, (_, i) => at(Math.round((255 * i) / (N_STOPS - 1)))),
        ends: ["two things", "likely one"],
      };
    }
    case "errors": {
      const [right, wrong] = [RIGHT_COLOR, WRONG_COLOR].map((color) => `rgb(${color.join(" ")})`);
      const samples = /** @type {Array<[string, string]>} */ ([
        [right, "same"],
        [wrong, "different"],
      ]);
      return { title: model.get("errors_title"), samples };
    }
    case "normals": {
      const color = (/** @type {number[]} */ normal) =>
        `rgb(${normal.map((x) => Math.round(127.5 + 127.5 * x)).join(" ")})`;
      const [first, second] = axisNames(model.get("_up") ?? [0, 0, 1]);
      const names = [first, second, "up", opposite(first), opposite(second), "down"];
      return { title: "Facing", samples: DIRECTIONS.map((normal, i) => [color(normal), names[i]]) };
    }
    default:
      return null;
  }
}

export function createLegend() {
  const title = element("div", { class: "sw-legend-title" });
  const bar = element("div", { class: "sw-legend-bar" });
  const [low, high] = [element("span"), element("span")];
  const ends = element("div", { class: "sw-legend-ends" }, [low, high]);
  const samples = element("div", { class: "sw-legend-samples" });
  const box = element("div", { class: "sw-legend", hidden: "" }, [title, bar, ends, samples]);
  return {
    element: box,
    /** @param {Legend | null} legend */
    show(legend) {
      box.hidden = legend === null;
      if (!legend) return;
      title.textContent = legend.title;
      bar.hidden = ends.hidden = !legend.colors;
      if (legend.colors) bar.style.background = `linear-gradient(to right, ${legend.colors.join(", ")})`;
      [low.textContent, high.textContent] = legend.ends ?? ["", ""];
      samples.replaceChildren(
        ...(legend.samples ?? []).map(([color, name]) => {
          const swatch = element("span", { class: "sw-swatch" });
          swatch.style.background = color;
          return element("span", {}, [swatch, name]);
        }),
      );
    },
  };
}

/** @param {string} axis  such as "+x" */
function opposite(axis) {
  return axis.replace(/[+−]/, (sign) => (sign === "+" ? "−" : "+"));
}

/** @param {number} value */
function numberText(value) {
  return Number(value.toPrecision(3)).toLocaleString("en", { maximumSignificantDigits: 3 });
}
