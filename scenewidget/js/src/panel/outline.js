/** A line over the picture, from corner to corner: an outline that is drawn, a plane, a distance. */

/** @typedef {import("../input/gestures.js").Place} Place */

const SVG = "http://www.w3.org/2000/svg";

export function createOutline() {
  const make = (/** @type {string} */ tag, /** @type {string} */ name) => {
    const node = document.createElementNS(SVG, tag);
    node.setAttribute("class", name);
    return node;
  };
  const halo = make("path", "sw-outline-halo");
  const line = make("path", "sw-outline-line");
  const dots = make("path", "sw-outline-dots");
  const label = make("text", "sw-outline-label");
  const svg = make("svg", "sw-outline");
  svg.setAttribute("aria-hidden", "true");
  svg.append(halo, line, dots, label);
  svg.style.display = "none";

  return {
    element: svg,

    /** @param {{ places: Place[], isClosed: boolean, hasDots: boolean, label: string }} what  no places: nothing */
    show({ places, isClosed, hasDots, label: words }) {
      svg.style.display = places.length > 0 ? "" : "none";
      const path = pathOf(places, isClosed);
      for (const node of [halo, line]) node.setAttribute("d", path);
      dots.setAttribute("d", hasDots ? places.map(({ x, y }) => `M${x} ${y}h.01`).join("") : "");
      label.textContent = words;
      if (!words) return;
      const [a, b] = [places[0], places[places.length - 1]];
      label.setAttribute("x", String((a.x + b.x) / 2));
      label.setAttribute("y", String((a.y + b.y) / 2 - 8));
    },
  };
}

/** @param {Place[]} places @param {boolean} isClosed */
export function pathOf(places, isClosed) {
  const corners = places.map(({ x, y }) => `${round(x)} ${round(y)}`);
  return corners.length === 0 ? "" : `M${corners.join("L")}${isClosed && corners.length > 2 ? "Z" : ""}`;
}

/** @param {number} x */
function round(x) {
  return Math.round(10 * x) / 10;
}
