/** The page around the picture: puts its pieces together and hands each what it shows. */

import { segmentRows } from "../labels/segment_rows.js";
import { createAnnouncer } from "./announcer.js";
import { createAutosave } from "./autosave.js";
import { createBoxes } from "./boxes.js";
import { element } from "./elements.js";
import { createErrorBar } from "./error_bar.js";
import { createHelpCard } from "./help_card.js";
import { createHistory } from "./history.js";
import { createLegend } from "./legend.js";
import { createNameForm } from "./name_form.js";
import { createOutline } from "./outline.js";
import { createPickedBar } from "./picked_bar.js";
import { createPicturePanel } from "./picture_panel.js";
import { createProgress } from "./progress.js";
import { createRubberBand } from "./rubber_band.js";
import { createSectionPanel } from "./section_panel.js";
import { createSegmentList } from "./segment_list.js";
import { createStatusLine } from "./status_line.js";
import { createToolOptionsBar } from "./tool_options.js";
import { createToolbar } from "./toolbar.js";

/** @typedef {import("../input/messages.js").Around} Around */

const ATTRIBUTES = {
  class: "scenewidget",
  tabindex: "0",
  role: "application",
  "aria-label": "3D view of a scan; press ? for the keys",
  "data-jp-suppress-context-menu": "",
  "data-lm-suppress-shortcuts": "true",
  "data-ready": "false",
  "data-busy": "false",
  "data-segments": "0",
  "data-hovered": "",
  "data-picked": "",
  "data-target": "",
  "data-pending": "0",
  "data-hidden": "0",
  "data-moving": "true",
};

/**
 * @param {HTMLElement} host
 * @param {Pick<Around, "send" | "on">} dispatcher
 */
export function createPanel(host, { send, on }) {
  const leave = () => root.focus({ preventScroll: true });
  const canvas = element("canvas", { class: "sw-canvas" });
  const autosave = createAutosave(send, leave);
  const toolbar = createToolbar(send, autosave);
  const status = createStatusLine();
  const progress = createProgress(send);
  const error = createErrorBar(send);
  const help = createHelpCard((isShown) => {
    toolbar.showHelp(isShown);
    if (!isShown) leave();
  });
  const legend = createLegend();
  const announcer = createAnnouncer();
  const picked = createPickedBar(send, leave);
  const nameForm = createNameForm(send, leave);
  const band = createRubberBand();
  const outline = createOutline();
  const boxes = createBoxes();
  const list = createSegmentList(send, leave);
  const section = createSectionPanel(send, leave);
  const picture = createPicturePanel(send, leave, {
    size: () => ({ width: canvas.clientWidth, height: canvas.clientHeight }),
    theme: () => (root.dataset.theme === "dark" ? "dark" : "light"),
  });
  const history = createHistory(send, leave);
  const options = createToolOptionsBar(send, leave);
  const ring = element("div", { class: "sw-ring", "aria-hidden": "true", hidden: "" });
  const twin = element("div", { class: "sw-twin", "aria-hidden": "true", hidden: "" });
  const cross = element("div", { class: "sw-aim", "aria-hidden": "true", hidden: "" });
  const preview = element("div", { class: "sw-preview", role: "status", hidden: "" }, ["Preview"]);
  const dock = element("div", { class: "sw-dock" }, [
    ...[autosave.bars, error.element, progress.element, options.element, picked.element],
  ]);
  const root = element("div", ATTRIBUTES, [
    element("div", { class: "sw-stage" }, [
      ...[
        canvas,
        twin,
        preview,
        band.element,
        boxes.element,
        outline.element,
        ring,
        cross,
        toolbar.element,
        legend.element,
        status.element,
      ],
      ...[progress.track, history.element, section.element, picture.element, dock],
      ...[nameForm.element, help.element, announcer.element],
    ]),
    list.element,
  ]);
  host.append(root);
  const tools = toolbar.element;
  const below = () => `${tools.offsetTop + tools.offsetHeight + 6}px`;
  new ResizeObserver(() => root.style.setProperty("--sw-below-tools", below())).observe(tools);

  root.addEventListener("contextmenu", (event) => {
    event.preventDefault();
    event.stopPropagation();
  });
  canvas.addEventListener("pointerdown", () => {
    nameForm.close();
    leave();
  });
  canvas.addEventListener("pointerenter", () => {
    const page = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    const { activeElement } = page; // a list or a button that was clicked on would have the keys meant for the picture
    if (activeElement !== root && root.contains(activeElement) && !nameForm.isOpen()) leave();
  });

  on({
    toggle({ what }) {
      if (what === "help") help.show(!help.isShown());
      else if (what === "section") {
        picture.show(false); // they take the same place
        section.show(!section.isShown());
      } else if (what === "picture") {
        section.show(false);
        picture.show(!picture.isShown());
      }
    },
    tool_taken({ tool }) {
      toolbar.showTool(tool);
      options.showTool(tool);
    },
    options: ({ options: next }) => options.show(next),
    outline: (what) => outline.show(what),
    boxes: (what) => boxes.show(what.boxes),
    ring({ place, radius }) {
      ring.hidden = !place;
      if (!place) return;
      ring.style.width = ring.style.height = `${2 * radius}px`;
      ring.style.transform = `translate(${place.x - radius}px, ${place.y - radius}px)`;
    },
    remark: ({ text }) => status.remark(text),
    hover: ({ words }) => status.hover(words),
    hint: (hint) => picked.show(hint),
    line: ({ from, to, isHeld }) => band.show(from, to, isHeld),
    marked: ({ segment }) => list.mark(segment),
    ask_name: (question) => nameForm.ask(question),
    cross({ isShown }) {
      cross.hidden = !isShown;
    },
    twin({ place }) {
      twin.hidden = !place;
      if (place) twin.style.transform = `translate(${place.x}px, ${place.y}px)`;
    },
  });

  return {
    root,
    canvas,
    dock,
    section,
    /** Close the help, a panel or the history; each says whether it was open. */
    closeHelp() {
      const isShown = help.isShown();
      if (isShown) help.show(false);
      return isShown;
    },
    closeSection() {
      const isShown = section.isShown();
      if (isShown) section.show(false);
      return isShown;
    },
    closePicture() {
      const isShown = picture.isShown();
      if (isShown) picture.show(false);
      return isShown;
    },
    closeHistory() {
      const { isShown } = history;
      if (isShown) send({ kind: "set", name: "history_shown", value: false });
      return isShown;
    },

    /** @param {boolean} isInside  whether one stands in the room */
    showInside(isInside) {
      if (root.dataset.inside === String(isInside)) return;
      root.dataset.inside = String(isInside);
      toolbar.showInside(isInside);
    },

    /** @param {import("../labels/shown_segments.js").ShownSegments} segments */
    showPreview({ isPreview, undo }) {
      root.dataset.preview = String(isPreview);
      preview.hidden = !isPreview;
      const words = undo ? "Preview: your edits come back when you let go" : "Preview";
      if (preview.textContent !== words) preview.textContent = words;
    },

    /** @param {import("./state.js").PanelState} state */
    update(state) {
      toolbar.update(state);
      section.update(state.section, state.lengths, state.editable);
      list.show(state.segmentList && state.hasPartition, state.noun);
      progress.update(state);
      error.update(state);
      legend.show(state.legend);
      picture.update(state);
      nameForm.offer(state.vocabulary, state.quickNames);
      history.update(state.editable && state.historyShown, state.history, state.nDone);
      autosave.update(state);
      help.update(state);
      status.update(state);
      announcer.update(state);
      root.dataset.busy = String(state.busy);
      root.dataset.hidden = String(state.nHidden);
      root.dataset.pending = String(state.pending);
    },

    /** List the segments, if the list is open. @param {Pick<Around, "view" | "segments">} shown */
    listSegments({ view, segments: { names, groups, confidence } }) {
      if (!list.isShown() || !view.partition) return;
      list.update(segmentRows(view.partition, { names, groups, confidence, hidden: view.hidden }));
    },

    /** Say why there is no picture. @param {string} message */
    showFailure(message) {
      root.replaceChildren(element("div", { class: "sw-failure", role: "alert" }, [message]));
    },
  };
}
