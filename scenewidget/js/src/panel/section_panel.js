/** The little panel in which the section box is moved: two ends on each of three sliders. */

import { localNumber } from "../labels/description.js";
import { isWhole, WHOLE } from "../scene/section.js";
import { element, iconButton, textButton } from "./elements.js";

/** @typedef {import("../scene/section.js").Range} Range */

const NAMES = ["Length", "Width", "Height"];
const STEP = 0.005;
const THINNEST = 0.02;

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when it closes
 */
export function createSectionPanel(send, leave) {
  const set = (/** @type {Range[]} */ value) => send({ kind: "set", name: "section", value });
  /** @type {Range[]} */
  let ranges = WHOLE;
  /** Metres, of which the ranges are parts. */
  let lengths = [0, 0, 0];

  const rows = NAMES.map((name, axis) => {
    const ends = ["from", "to"].map((end, i) => {
      const input = element("input", {
        ...{ class: "sw-end", type: "range", min: "0", max: "1", step: String(STEP) },
        "aria-label": `${name} ${end}`,
      });
      input.oninput = () => {
        const [low, high] = ranges[axis];
        const value = Number(input.value);
        /** @type {Range} */
        const range =
          i === 0 ? [Math.min(value, high - THINNEST), high] : [low, Math.max(value, low + THINNEST)];
        set(ranges.map((other, k) => (k === axis ? range : other)));
        input.value = String(range[i]);
      };
      return input;
    });
    const kept = element("span", { class: "sw-kept" });
    const slider = element("div", { class: "sw-between" }, [kept, ...ends]);
    const text = element("span", { class: "sw-section-text" });
    return { ends, kept, text, parts: [element("span", {}, [name]), slider, text] };
  });
  const ceiling = textButton("Cut the ceiling off", "Keep what is below the ceiling (Shift + X)");
  const take = textButton("Make it a segment", "What the box shows becomes a segment of its own");
  const reset = textButton("Show the whole scan", "Cut nothing (Shift + X)");
  const close = iconButton("close", "Close the section panel", "X");
  const panel = element("div", { class: "sw-section", role: "dialog", "aria-label": "Section", hidden: "" }, [
    element("div", { class: "sw-section-head" }, [element("b", {}, ["Section"]), close]),
    element(
      "div",
      { class: "sw-section-rows" },
      rows.flatMap(({ parts }) => parts),
    ),
    element("div", { class: "sw-section-foot" }, [ceiling, reset, take]),
  ]);
  const show = (/** @type {boolean} */ isShown, { isFocused = true } = {}) => {
    if (panel.hidden !== isShown) return;
    panel.hidden = !isShown;
    if (!isFocused) return;
    if (isShown) rows[2].ends[1].focus({ preventScroll: true });
    else leave();
  };
  ceiling.onclick = () => send({ kind: "cut_ceiling" });
  take.onclick = () => send({ kind: "take_box" });
  reset.onclick = () => set(WHOLE);
  close.onclick = () => show(false);
  panel.onkeydown = (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    show(false);
  };

  return {
    element: panel,
    show,
    isShown: () => !panel.hidden,

    /**
     * @param {Range[]} next
     * @param {number[]} metres  of the whole scan along each axis
     * @param {boolean} [isEditable]
     */
    update(next, metres, isEditable = false) {
      [ranges, lengths] = [next, metres];
      rows.forEach(({ ends, kept, text }, axis) => {
        const [low, high] = ranges[axis];
        ends[0].value = String(low);
        ends[1].value = String(high);
        // of two thumbs at one place, the one that can still move lies on top
        ends[0].style.zIndex = low > 0.5 ? "1" : "";
        kept.style.left = `${100 * low}%`;
        kept.style.right = `${100 * (1 - high)}%`;
        const [from, to] = [low, high].map((t) => localNumber(t * lengths[axis], lengths[axis] < 1 ? 2 : 1));
        text.textContent = `${from} – ${to} m`;
        for (const [i, end] of ends.entries()) end.setAttribute("aria-valuetext", `${[from, to][i]} m`);
      });
      reset.disabled = isWhole(ranges);
      take.hidden = !isEditable || isWhole(ranges);
    },
  };
}
