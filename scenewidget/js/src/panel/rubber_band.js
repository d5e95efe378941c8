/** The line between the part being moved and the pointer. */

/** @typedef {import("../input/gestures.js").Place} Place */

const SVG = "http://www.w3.org/2000/svg";

/** Goes over the canvas; shows nothing until told. */
export function createRubberBand() {
  const make = (/** @type {string} */ tag, /** @type {Record<string, string>} */ attributes) => {
    const node = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    return node;
  };
  const lines = [make("line", { class: "sw-rubber-halo" }), make("line", { class: "sw-rubber-line" })];
  const ends = [make("circle", { r: "4" }), make("circle", { r: "6", class: "sw-rubber-end" })];
  const svg = make("svg", { class: "sw-rubber", "aria-hidden": "true" });
  svg.append(...lines, ...ends);
  svg.style.display = "none";
  return {
    element: svg,

    /**
     * @param {Place | null} from  null: nothing
     * @param {Place | null} to  null: where it begins stays marked
     * @param {boolean} isOnTarget
     */
    show(from, to, isOnTarget) {
      svg.style.display = from ? "" : "none";
      for (const node of [...lines, ends[1]]) node.style.display = to ? "" : "none";
      if (!from) return;
      svg.classList.toggle("sw-rubber-held", isOnTarget);
      for (const line of lines) {
        const { x, y } = to ?? from;
        for (const [name, value] of Object.entries({ x1: from.x, y1: from.y, x2: x, y2: y })) {
          line.setAttribute(name, String(value));
        }
      }
      [from, to ?? from].forEach((place, i) => {
        ends[i].setAttribute("cx", String(place.x));
        ends[i].setAttribute("cy", String(place.y));
      });
    },
  };
}
