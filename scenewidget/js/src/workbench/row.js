/** One scan of the queue: its picture, its name, and how it stands with it. */

import { element } from "../panel/elements.js";
import { STATE_NAMES, spokenCount, spokenTime } from "./queue.js";

/** @typedef {import("./queue.js").Row} Row */

export const ROW_HEIGHT = 68; // pixels, as in the style sheet

/**
 * @param {Row} row
 * @param {{ id: string, hasTruth: boolean }} options
 */
export function createRow(row, { id, hasTruth }) {
  const picture = element("img", { class: "sww-picture", alt: "", hidden: "" });
  const facts = [];
  if (row.segments !== null && row.faces !== null)
    facts.push(`${row.segments} segments`, `${spokenCount(row.faces)} faces`);
  if (row.edits) facts.push(row.edits === 1 ? "1 edit" : `${row.edits} edits`);
  if (row.people.length) facts.push(`${row.people.join(", ")}, ${spokenTime(row.seconds)}`);
  const node = element(
    "div",
    { class: "sww-row", role: "option", id, "data-scan": row.scan, "data-state": row.state },
    [
      element("div", { class: "sww-frame" }, [picture]),
      element("div", { class: "sww-text" }, [
        element("div", { class: "sww-name", title: row.scan }, [row.scan]),
        element("div", { class: row.error ? "sww-error" : "sww-facts", title: row.error }, [
          row.error || facts.join(" · "),
        ]),
      ]),
      element(
        "div",
        { class: "sww-number", title: "Rand index error against the truth" },
        errorText(row, hasTruth),
      ),
      doubtBar(row),
      element("div", { class: "sww-state" }, [STATE_NAMES[row.state]]),
    ],
  );
  return {
    element: node,

    /** @param {string} url  "" for none */
    showPicture(url) {
      picture.hidden = url === "";
      if (url) picture.src = url;
    },

    /** @param {number} index @param {number} n @param {{ isChosen: boolean, isOpen: boolean }} how */
    place(index, n, { isChosen, isOpen }) {
      node.style.transform = `translateY(${index * ROW_HEIGHT}px)`;
      node.setAttribute("aria-posinset", String(index + 1));
      node.setAttribute("aria-setsize", String(n));
      node.setAttribute("aria-selected", String(isChosen));
      node.dataset.open = String(isOpen);
    },
  };
}

/** @param {Row} row @param {boolean} hasTruth */
function errorText(row, hasTruth) {
  if (!hasTruth) return [];
  const before = row.before === null ? "–" : row.before.toFixed(3);
  return row.now === null ? [before] : [element("s", {}, [before]), ` ${row.now.toFixed(3)}`];
}

/** @param {Row} row */
function doubtBar(row) {
  if (row.doubt === null) return element("div", { class: "sww-doubt" });
  const percent = Math.round(100 * row.doubt);
  const fill = element("i", { class: "sww-fill" });
  fill.style.width = `${Math.min(100, percent)}%`;
  return element(
    "div",
    { class: "sww-doubt", title: `About ${percent} % of the surface is probably wrong` },
    [element("span", {}, [`${percent} % doubt`]), element("div", { class: "sww-track" }, [fill])],
  );
}
