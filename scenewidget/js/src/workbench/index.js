/** The queue of scans above the editor: what there is, how it stands with each, and what comes next. */

import { element } from "../panel/elements.js";
import { watchTheme } from "../panel/theme.js";
import { watchConnection } from "../wire/connection.js";
import { listen, on } from "../wire/listen.js";
import { createPictures } from "./pictures.js";
import {
  candidates,
  chosenRows,
  countStates,
  inSight,
  ORDERS,
  STATE_NAMES,
  STATES,
  scrolledTo,
} from "./queue.js";
import { createRow, ROW_HEIGHT } from "./row.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {import("./queue.js").Row} Row */

const GONE = "The kernel is gone: nothing can be opened. Run the cell again.";
const KEYS = "↑ ↓ choose · Enter open · N next · P previous · D done · R to review · / search";
let nLists = 0;

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @returns {() => void}  undoes everything
 */
function render({ model, el }) {
  const life = new AbortController();
  const { signal } = life;
  const id = `sww-${++nLists}`;
  /** @type {{ state: string, text: string, order: import("./queue.js").Order }} */
  const wish = { state: "", text: "", order: "doubt" };
  /** @type {Row[]} */
  let shown = [];
  /** @type {Map<string, ReturnType<typeof createRow>>} */
  const drawn = new Map();
  let chosen = "";

  // --- pieces of the page
  const title = element("span", { class: "sww-title" });
  const bar = element("div", { class: "sww-progress", role: "img" }, [
    element("i", { class: "sww-part-done" }),
    element("i", { class: "sww-part-review" }),
    element("i", { class: "sww-part-begun" }),
  ]);
  const search = element("input", {
    class: "sww-search",
    type: "search",
    placeholder: "Search",
    "aria-label": "Search scans and people",
  });
  const order = element(
    "select",
    { class: "sww-order", "aria-label": "Order" },
    Object.entries(ORDERS).map(([value, { name }]) => element("option", { value }, [name])),
  );
  const filters = element("div", { class: "sww-filters", role: "group", "aria-label": "State" });
  const list = element("div", {
    class: "sww-list",
    role: "listbox",
    tabindex: "0",
    "aria-label": "Scans",
    title: KEYS,
    "data-lm-suppress-shortcuts": "true",
  });
  const sheet = element("div", { class: "sww-sheet", role: "presentation" });
  list.append(sheet);
  const buttons = {
    previous: button("Previous", "P", () => go("previous", -1)),
    next: button("Next", "N", () => go("next", 1)),
    review: button("To review", "R", () => model.send({ kind: "review" })),
    done: button("Done", "D", () => go("done", 1)),
    refresh: button("Refresh", "", () => model.send({ kind: "refresh" })),
  };
  buttons.done.classList.add("sww-main");
  const open = element("span", { class: "sww-open" });
  const note = element("span", { class: "sww-note", role: "status" });
  const root = element("section", { class: "sww", "aria-label": "Queue of scans" }, [
    element("div", { class: "sww-head" }, [title, bar, search, order]),
    element("div", { class: "sww-head" }, [filters, buttons.refresh]),
    list,
    element("div", { class: "sww-foot" }, [
      open,
      note,
      buttons.previous,
      buttons.next,
      buttons.review,
      buttons.done,
    ]),
  ]);
  el.append(root);

  const pictures = createPictures({
    ask: (scans) => model.send({ kind: "pictures", scans }),
    show: (scan, url) => drawn.get(scan)?.showPicture(url),
  });

  // --- what people want
  /** @param {"next" | "previous" | "done"} kind @param {number} step */
  function go(kind, step) {
    model.send({ kind, scans: candidates(shown, model.get("current"), step) });
  }

  /** @param {string} scan */
  function openScan(scan) {
    const row = shown.find((one) => one.scan === scan);
    if (row && row.state !== "failed") model.send({ kind: "open", scans: [scan] });
  }

  /** @param {string} scan */
  function choose(scan) {
    chosen = scan;
    const index = shown.findIndex((row) => row.scan === scan);
    if (index >= 0) list.scrollTop = scrolledTo(index, sight());
    draw();
  }

  const sight = () => ({ top: list.scrollTop, height: list.clientHeight, rowHeight: ROW_HEIGHT });

  /** @param {number} by */
  function move(by) {
    if (shown.length === 0) return;
    const at = shown.findIndex((row) => row.scan === chosen);
    const index = Math.max(0, Math.min(shown.length - 1, at < 0 ? 0 : at + by));
    choose(shown[index].scan);
  }

  const page = () => Math.max(1, Math.floor(list.clientHeight / ROW_HEIGHT));
  /** @type {Record<string, () => void>} */
  const keys = {
    ArrowDown: () => move(1),
    ArrowUp: () => move(-1),
    PageDown: () => move(page()),
    PageUp: () => move(-page()),
    Home: () => move(-shown.length),
    End: () => move(shown.length),
    Enter: () => openScan(chosen),
    n: () => go("next", 1),
    p: () => go("previous", -1),
    d: () => model.get("current") && go("done", 1),
    r: () => model.get("current") && model.send({ kind: "review" }),
    "/": () => search.focus(),
  };
  list.addEventListener("keydown", (event) => {
    const act =
      event.ctrlKey || event.metaKey || event.altKey
        ? undefined
        : (keys[event.key] ?? keys[event.key.toLowerCase()]);
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  });
  search.addEventListener("input", () => {
    wish.text = search.value;
    list.scrollTop = 0;
    update();
  });
  search.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Enter" || event.key === "ArrowDown") {
      event.preventDefault();
      list.focus();
      move(0);
    }
  });
  order.addEventListener("change", () => {
    wish.order = /** @type {import("./queue.js").Order} */ (order.value);
    list.scrollTop = 0;
    update();
  });
  list.addEventListener("scroll", () => draw(), { passive: true });
  const resized = new ResizeObserver(() => draw());
  resized.observe(list);

  // --- what is shown
  function update() {
    /** @type {Row[]} */
    const rows = model.get("rows");
    shown = chosenRows(rows, wish);
    const counts = countStates(rows);
    const n = Math.max(1, rows.length);
    title.textContent = `${counts.done} of ${rows.length} done`;
    bar.setAttribute(
      "aria-label",
      `${counts.done} done, ${counts.review} to review, ${counts.begun} begun, of ${rows.length}`,
    );
    [counts.done, counts.review, counts.begun].forEach((count, k) => {
      /** @type {HTMLElement} */ (bar.children[k]).style.width = `${(100 * count) / n}%`;
    });
    showFilters(counts, rows.length);
    list.style.height = `${Math.min(model.get("height"), Math.max(1, shown.length) * ROW_HEIGHT)}px`;
    sheet.style.height = `${shown.length * ROW_HEIGHT}px`;
    root.dataset.shown = String(shown.length);
    const current = model.get("current");
    root.dataset.current = current;
    open.textContent = current || "Nothing is open";
    note.textContent = model.get("note");
    showConnection();
    for (const view of drawn.values()) view.element.remove();
    drawn.clear();
    if (!shown.some((row) => row.scan === chosen)) chosen = shown[0]?.scan ?? "";
    draw();
  }

  /** @param {Record<string, number>} counts @param {number} n */
  function showFilters(counts, n) {
    const wanted = ["", ...STATES].filter((state) => state === "" || state !== "failed" || counts.failed > 0);
    filters.replaceChildren(
      ...wanted.map((state) => {
        const name = state === "" ? "All" : STATE_NAMES[/** @type {keyof typeof STATE_NAMES} */ (state)];
        const count = element("b", {}, [String(state === "" ? n : counts[state])]);
        const chip = element(
          "button",
          {
            class: "sww-chip",
            type: "button",
            "aria-pressed": String(wish.state === state),
            "data-state": state,
          },
          [name, count],
        );
        chip.addEventListener("click", () => {
          wish.state = state;
          list.scrollTop = 0;
          update();
          /** @type {HTMLElement | null} */ (filters.querySelector(`[data-state="${state}"]`))?.focus();
        });
        return chip;
      }),
    );
  }

  function draw() {
    const [first, end] = inSight({ n: shown.length, ...sight() });
    const wanted = new Set();
    for (let k = first; k < end; k++) {
      const row = shown[k];
      wanted.add(row.scan);
      let view = drawn.get(row.scan);
      if (!view) {
        view = createRow(row, { id: `${id}-${k}`, hasTruth: model.get("has_truth") });
        view.element.addEventListener("click", () => {
          list.focus({ preventScroll: true });
          choose(row.scan);
        });
        view.element.addEventListener("dblclick", () => openScan(row.scan));
        view.showPicture(pictures.of(row.scan));
        drawn.set(row.scan, view);
        sheet.append(view.element);
      }
      view.place(k, shown.length, {
        isChosen: row.scan === chosen,
        isOpen: row.scan === model.get("current"),
      });
    }
    for (const [scan, view] of drawn) {
      if (wanted.has(scan)) continue;
      view.element.remove();
      drawn.delete(scan);
    }
    const active = drawn.get(chosen);
    if (active) list.setAttribute("aria-activedescendant", active.element.id);
    else list.removeAttribute("aria-activedescendant");
    pictures.want(/** @type {string[]} */ ([...wanted]));
  }

  const connection = watchConnection(model, el, showConnection, signal);
  function showConnection() {
    const isLive = connection.isLive();
    root.dataset.live = String(isLive);
    const hasCurrent = model.get("current") !== "";
    for (const one of Object.values(buttons)) one.disabled = !isLive;
    buttons.previous.disabled ||= !hasCurrent;
    buttons.review.disabled ||= !hasCurrent;
    buttons.done.disabled ||= !hasCurrent;
    if (!isLive) note.textContent = GONE;
  }

  const stopTheme = watchTheme(el, (isDark) => {
    root.dataset.theme = isDark ? "dark" : "light";
  });
  on(
    model,
    "msg:custom",
    (message, buffers) => {
      if (message.kind === "pictures") pictures.take(message.scans, buffers);
      if (message.kind === "redraw") {
        pictures.forget(message.scan);
        draw();
      }
    },
    signal,
  );
  listen(model, { state: ["rows", "current", "note", "has_truth", "height"] }, update, signal);
  on(model, "change:current", () => choose(model.get("current") || chosen), signal);
  update();
  root.dataset.ready = "true";
  return () => {
    life.abort();
    resized.disconnect();
    stopTheme();
    pictures.clear();
    root.remove();
  };
}

/** @param {string} name @param {string} key @param {() => void} act */
function button(name, key, act) {
  const node = element(
    "button",
    {
      class: "sww-button",
      type: "button",
      ...(key ? { title: `${name} (${key}, in the list)` } : {}),
    },
    [name],
  );
  node.addEventListener("click", act);
  return node;
}

export default { render };
