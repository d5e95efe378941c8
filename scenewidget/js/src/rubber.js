/** The line between the part being moved and the pointer. */

/** @typedef {import("./gestures.js").Place} Place */

const SVG = "http://www.w3.org/2000/svg";

/** Goes over the canvas; shows nothing until told. */
export function createRubber() {
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

    /** @param {Place | null} from @param {Place | null} to  either is null: nothing @param {boolean} isOnTarget */
    show(from, to, isOnTarget) {
      svg.style.display = from && to ? "" : "none";
      if (!from || !to) return;
      svg.classList.toggle("sw-rubber-held", isOnTarget);
      for (const line of lines) {
        for (const [name, value] of Object.entries({ x1: from.x, y1: from.y, x2: to.x, y2: to.y })) {
          line.setAttribute(name, String(value));
        }
      }
      [from, to].forEach((place, i) => {
        ends[i].setAttribute("cx", String(place.x));
        ends[i].setAttribute("cy", String(place.y));
      });
    },
  };
}
