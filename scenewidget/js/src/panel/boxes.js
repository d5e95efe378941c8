/** The upright boxes of segments as lines over the picture, with the measures of the one that is pointed at. */

import { localNumber } from "../labels/description.js";
import { NONE } from "../labels/partition.js";
import { cornersOfBox, pathOfBox, sizesOfBox } from "../scene/boxes.js";
import { readArray } from "../wire/wire.js";

/** @typedef {import("../scene/boxes.js").BoxLines} BoxLines */

const SVG = "http://www.w3.org/2000/svg";

/**
 * What is to be drawn of them now.
 * @param {Pick<import("../input/messages.js").Around, "model" | "view" | "segments">} around
 * @param {number | null} face  that is pointed at
 * @returns {BoxLines[]}
 */
export function boxLines({ model, view, segments }, face) {
  const boxes = /** @type {Float32Array | null} */ (
    model.get("boxes") ? readArray(model, "segment_box") : null
  );
  const { partition, mesh, hidden } = view;
  if (!boxes || !partition || !mesh || segments.isPreview) return [];
  const { atomSegment, faceAtom, segmentColors } = partition;
  const pointed = face === null ? NONE : atomSegment[faceAtom[face]];
  const seen = new Set(hidden ? atomSegment.filter((_, atom) => !hidden[atom]) : atomSegment);
  return [...seen].flatMap((segment) => {
    const corners = segment === NONE ? null : cornersOfBox(boxes, segment, (point) => view.fromOwn(point));
    if (!corners) return [];
    const places = corners.map((corner) => view.placeOf(corner));
    const [top = null] = places.filter((place) => place !== null).sort((a, b) => a.y - b.y);
    const isPointed = segment === pointed;
    return {
      path: pathOfBox(places),
      color: `rgb(${segmentColors.subarray(3 * segment, 3 * segment + 3).join(" ")})`,
      isPointed,
      label: isPointed ? measuresOf(sizesOfBox(boxes, segment)) : "",
      top,
    };
  });
}

export function createBoxes() {
  const make = (/** @type {string} */ tag, /** @type {Record<string, string>} */ attributes) => {
    const node = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    return node;
  };
  const svg = make("svg", { class: "sw-outline", "aria-hidden": "true" });
  let isEmpty = true;
  return {
    element: svg,

    /** @param {BoxLines[]} boxes */
    show(boxes) {
      if (isEmpty && boxes.length === 0) return;
      isEmpty = boxes.length === 0;
      const nodes = boxes.flatMap(({ path, color, isPointed, label, top }) => {
        const kind = isPointed ? "sw-box sw-box-pointed" : "sw-box";
        const line = make("path", { d: path, class: kind, stroke: color });
        if (!label || !top) return [line];
        const text = make("text", { class: "sw-outline-label", x: `${top.x}`, y: `${top.y - 8}` });
        text.textContent = label;
        return [line, text];
      });
      svg.replaceChildren(...nodes);
    },
  };
}

/** @param {number[]} sizes  metres */
export function measuresOf(sizes) {
  return `${sizes.map((size) => localNumber(size, 2)).join(" × ")} m`;
}
