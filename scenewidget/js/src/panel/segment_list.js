/**
 * The list of segments beside the picture: a table to sort, to point with and to hide by.
 *
 * Every row has two buttons, to show and to choose; of all rows only the current one is a stop of the Tab
 * key, arrows go on from there. Rows are kept and changed in place, so an edit touches two of five hundred.
 */

import { counted, localNumber, segmentTitle } from "../labels/description.js";
import { NONE } from "../labels/partition.js";
import { FIRST_DESCENDING, sorted } from "../labels/segment_rows.js";
import { element, iconButton } from "./elements.js";

/** @typedef {import("../labels/segment_rows.js").Row} Row */
/** @typedef {import("../labels/segment_rows.js").Column} Column */

/** @type {Array<[Column, string, string]>} */
const COLUMNS = [
  ["name", "Name", "Sort by name"],
  ["faces", "Faces", "Sort by number of faces"], // `call` says points of a cloud
  ["area", "m²", "Sort by area in square metres"],
  ["confidence", "Conf.", "Sort by confidence: how probably it is right; the doubtful first"],
];
const EYE =
  "M1.8 8S4 3.8 8 3.8 14.2 8 14.2 8 12 12.2 8 12.2 1.8 8 1.8 8ZM8 6.2a1.8 1.8 0 1 1 0 3.6 1.8 1.8 0 0 1 0-3.6";
const SHUT = "M1.8 8S4 12.2 8 12.2 14.2 8 14.2 8M4 11l-1 1.6M8 12.2V14M12 11l1 1.6";

/** @type {Record<string, "hide" | "isolate" | "frame" | "name">} */
const KEYS = { h: "hide", i: "isolate", f: "frame", n: "name" };

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when it closes
 */
export function createSegmentList(send, leave) {
  const count = element("span", { class: "sw-list-count" });
  const close = iconButton("close", "Close the list", "L");
  /** @type {Map<Column, { cell: HTMLElement, button: HTMLButtonElement }>} */
  const heads = new Map();
  for (const [column, text, title] of COLUMNS) {
    const button = element("button", { class: "sw-sort", type: "button", title }, [text]);
    button.onclick = () => sortBy(column);
    const cell = element("th", { scope: "col", class: `sw-col-${column}` }, [button]);
    heads.set(column, { cell, button });
  }
  const body = element("tbody");
  const table = element("table", { "aria-label": "Segments" }, [
    element("thead", {}, [
      element("tr", {}, [
        element("th", { scope: "col", class: "sw-col-eye" }, [
          element("span", { class: "sw-unseen" }, ["Shown"]),
        ]),
        ...[...heads.values()].map(({ cell }) => cell),
      ]),
    ]),
    body,
  ]);
  const scroll = element("div", { class: "sw-list-scroll" }, [table]);
  const panel = element("aside", { class: "sw-list", "aria-label": "List of segments", hidden: "" }, [
    element("div", { class: "sw-list-head" }, [element("b", {}, ["Segments"]), count, close]),
    scroll,
  ]);

  /** @type {import("../labels/segment_rows.js").Order} */
  let order = { column: "area", isDescending: true };
  /** @type {Row[]} */
  let rows = [];
  /** @type {Map<number, ReturnType<typeof makeRow>>} */
  let lines = new Map();
  /** The row that Tab goes to. */
  let current = NONE;
  let marked = /** @type {number | null} */ (null);
  let request = 0;
  let noun = "face";

  /** @param {string} given  what faces are called */
  function call(given) {
    noun = given;
    const button = /** @type {HTMLElement} */ (heads.get("faces")?.button);
    button.textContent = `${noun[0].toUpperCase()}${noun.slice(1)}s`;
    button.title = `Sort by number of ${noun}s`;
  }

  const titleOf = (/** @type {number} */ segment) =>
    segmentTitle(segment, { [segment]: rows.find((row) => row.segment === segment)?.name ?? "" });
  const point = (/** @type {number | null} */ segment) => send({ kind: "listed", segment });
  const lineOf = (/** @type {Event} */ event) =>
    event.target instanceof Element ? event.target.closest("tr")?.dataset.segment : undefined;

  function arrange() {
    const ordered = sorted(rows, order).map(({ segment }) => lines.get(segment)?.line);
    const isSame = ordered.length === body.rows.length && ordered.every((line, i) => line === body.rows[i]);
    if (!isSame) {
      const focused = /** @type {Document | ShadowRoot} */ (panel.getRootNode()).activeElement;
      body.replaceChildren(.../** @type {HTMLElement[]} */ (ordered));
      if (focused instanceof HTMLElement && body.contains(focused)) focused.focus({ preventScroll: true });
    }
    for (const [column, { cell, button }] of heads) {
      const isSorted = column === order.column;
      cell.setAttribute("aria-sort", !isSorted ? "none" : order.isDescending ? "descending" : "ascending");
      button.dataset.order = !isSorted ? "" : order.isDescending ? "down" : "up";
    }
  }

  /** @param {Column} column */
  function sortBy(column) {
    const isDescending = order.column === column ? !order.isDescending : FIRST_DESCENDING[column];
    order = { column, isDescending };
    arrange();
    scroll.scrollTop = 0;
  }

  /** @param {number} segment  the one that Tab and arrows go to */
  function setCurrent(segment) {
    lines.get(current)?.setTabbable(false);
    current = segment;
    lines.get(current)?.setTabbable(true);
  }

  /** Bring a row into sight, without moving the page. @param {HTMLElement} line */
  function reveal(line) {
    const top = line.offsetTop - (table.tHead?.offsetHeight ?? 0);
    const bottom = line.offsetTop + line.offsetHeight - scroll.clientHeight;
    scroll.scrollTop = Math.max(Math.min(scroll.scrollTop, top), bottom);
  }

  body.addEventListener("pointerover", (event) => {
    const segment = lineOf(event);
    point(segment === undefined ? null : Number(segment));
  });
  body.addEventListener("pointerleave", () => point(null));
  body.addEventListener("click", (event) => {
    const segment = lineOf(event);
    if (segment === undefined) return;
    setCurrent(Number(segment));
    if (/** @type {Element} */ (event.target).closest(".sw-eye"))
      send({ kind: "act_on_segment", what: "hide", segment: Number(segment) });
    else send({ kind: "choose_segment", segment: Number(segment) });
  });
  body.addEventListener("focusin", (event) => {
    const segment = lineOf(event);
    if (segment === undefined) return;
    setCurrent(Number(segment));
    reveal(/** @type {HTMLElement} */ (lines.get(current)?.line));
    if (/** @type {Element} */ (event.target).matches(":focus-visible")) point(current);
  });
  body.addEventListener("focusout", () => point(null));
  body.addEventListener("keydown", (event) => {
    const line = lines.get(current)?.line;
    if (!line || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    const all = [...body.rows];
    const at = all.indexOf(line);
    const page = Math.max(1, Math.floor(scroll.clientHeight / line.offsetHeight) - 2);
    /** @type {Record<string, number>} */
    const goals = {
      ArrowDown: at + 1,
      ArrowUp: at - 1,
      PageDown: at + page,
      PageUp: at - page,
      Home: 0,
      End: all.length - 1,
    };
    const isEye = event.target instanceof Element && event.target.closest(".sw-eye") !== null;
    if (event.key in goals) {
      const goal = all[Math.min(all.length - 1, Math.max(0, goals[event.key]))];
      lines.get(Number(goal.dataset.segment))?.focus(isEye);
    } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      lines.get(current)?.focus(event.key === "ArrowLeft");
    } else if (event.key.toLowerCase() in KEYS) {
      send({ kind: "act_on_segment", what: KEYS[event.key.toLowerCase()], segment: current });
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });
  close.onclick = () => {
    send({ kind: "set", name: "segment_list", value: false });
    leave();
  };

  return {
    element: panel,

    /** @param {boolean} isShown @param {string} [called]  what faces are called */
    show(isShown, called = noun) {
      if (called !== noun) call(called);
      if (panel.hidden !== isShown) return;
      panel.hidden = !isShown;
      if (!isShown) point(null);
    },
    isShown: () => !panel.hidden,

    /** @param {Row[]} next */
    update(next) {
      rows = next;
      const nSegments = rows.filter(({ segment }) => segment !== NONE).length;
      const nHidden = rows.filter(({ segment, hidden }) => segment !== NONE && hidden === "all").length;
      count.textContent = nHidden > 0 ? `${nSegments} · ${nHidden} hidden` : String(nSegments);
      const before = lines;
      lines = new Map(rows.map((row) => [row.segment, before.get(row.segment) ?? makeRow(row.segment)]));
      const decimals = rows.every(({ area }) => area < 1) ? 4 : 2; // of what lies on a table, mm² are a lot
      for (const row of rows)
        lines.get(row.segment)?.update(row, noun, row.whole === null ? "" : titleOf(row.whole), decimals);
      arrange();
      const isGone = !lines.has(current);
      const first = body.rows[0]?.dataset.segment;
      if (isGone) setCurrent(first === undefined ? NONE : Number(first));
      else setCurrent(current);
      if (marked !== null) lines.get(marked)?.line.classList.add("sw-marked");
    },

    /** Show which segment is pointed at in the picture. @param {number | null} segment */
    mark(segment) {
      if (segment === marked) return;
      lines.get(marked ?? NONE)?.line.classList.remove("sw-marked");
      marked = segment;
      const line = segment === null ? undefined : lines.get(segment)?.line;
      line?.classList.add("sw-marked");
      cancelAnimationFrame(request);
      if (!line || panel.hidden || panel.matches(":hover")) return;
      request = requestAnimationFrame(() => reveal(line)); // measuring would hold up the pointer
    },
  };
}

/** @param {number} segment */
function makeRow(segment) {
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.append(path);
  const eye = element("button", { class: "sw-eye", type: "button", tabindex: "-1" }, [svg]);
  const swatch = element("span", { class: "sw-swatch" });
  const title = element("span", { class: "sw-row-title" });
  const choose = element("button", { class: "sw-row-name", type: "button", tabindex: "-1" }, [swatch, title]);
  const [faces, area, confidence] = [element("td"), element("td"), element("td")];
  const line = element("tr", { "data-segment": String(segment) }, [
    element("td", { class: "sw-col-eye" }, [eye]),
    element("th", { scope: "row" }, [choose]),
    ...[faces, area, confidence],
  ]);
  let last = "";
  return {
    line,
    /**
     * @param {Row} row
     * @param {string} noun
     * @param {string} whole  that it is a part of, "" for nothing
     * @param {number} decimals  of its area
     */
    update(row, noun, whole, decimals) {
      const signature = JSON.stringify([row, noun, whole, decimals]);
      if (signature === last) return;
      last = signature;
      const isHidden = row.hidden === "all";
      const name = row.name || (segment === NONE ? "Unlabeled" : `Segment ${segment}`);
      title.textContent = name;
      choose.title = [
        segment === NONE ? "Unlabeled" : segmentTitle(segment, { [segment]: row.name }),
        counted(row.faces, noun),
        ...(whole ? [`part of ${whole}`] : []),
      ].join(", ");
      line.classList.toggle("sw-part", whole !== "");
      title.classList.toggle("sw-unnamed", !row.name);
      swatch.style.background = row.color;
      line.dataset.hidden = row.hidden;
      path.setAttribute("d", isHidden ? SHUT : EYE);
      eye.setAttribute("aria-label", `Show ${name}`);
      eye.setAttribute("aria-pressed", row.hidden === "none" ? "true" : isHidden ? "false" : "mixed");
      eye.title = isHidden ? "Show (H)" : "Hide (H)";
      faces.textContent = localNumber(row.faces);
      area.textContent = row.area > 0 ? localNumber(row.area, decimals) : "";
      confidence.textContent = row.confidence === null ? "" : localNumber(row.confidence, 2);
    },
    /** @param {boolean} isTabbable */
    setTabbable(isTabbable) {
      for (const button of [eye, choose]) button.tabIndex = isTabbable ? 0 : -1;
    },
    /** @param {boolean} isEye */
    focus(isEye) {
      (isEye ? eye : choose).focus({ preventScroll: true });
    },
  };
}
