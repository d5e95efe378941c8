/** The little panel that saves the picture as a file, at a size of its own. */

import { element, iconButton, textButton } from "./elements.js";
import { createNumberInput, numberOf } from "./number_input.js";
import { drawLegend } from "./picture_legend.js";

const SCALES = [1, 2, 3, 4];
const FILE = "scan.png";
const BACKGROUND = { light: "#ffffff", dark: "#22252a" };

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when it closes
 * @param {{ size: () => { width: number, height: number }, theme: () => "light" | "dark" }} shown  size: of the picture on the page
 */
export function createPicturePanel(send, leave, shown) {
  /** @type {import("./legend.js").Legend | null} */
  let legend = null;
  const [width, height] = ["Width", "Height"].map((name) =>
    createNumberInput({ step: 10, low: 1 }, { class: "sw-pixels", "aria-label": `${name} in pixels` }, say),
  );
  const scale = element("select", { class: "sw-select", "aria-label": "Scale" }, [
    ...SCALES.map((times) => element("option", { value: String(times) }, [`× ${times}`])),
  ]);
  const clear = element("input", { type: "checkbox", "aria-label": "Transparent background" });
  const withLegend = element("input", { type: "checkbox", "aria-label": "With the legend" });
  const legendField = element("label", { class: "sw-check" }, [withLegend, "With the legend"]);
  const save = textButton("Save PNG", "Save the picture as a file");
  const copy = textButton("Copy", "Copy the picture");
  const note = element("div", { class: "sw-picture-note", role: "status" });
  const close = iconButton("close", "Close the picture panel", "P");
  const panel = element(
    "form",
    { class: "sw-section sw-picture", role: "dialog", "aria-label": "Picture", hidden: "" },
    [
      element("div", { class: "sw-section-head" }, [element("b", {}, ["Picture"]), close]),
      element("div", { class: "sw-picture-size" }, [width, "×", height, scale]),
      element("label", { class: "sw-check" }, [clear, "Transparent background"]),
      legendField,
      note,
      element("div", { class: "sw-section-foot" }, [save, copy]),
    ],
  );
  scale.value = "2";

  function asked() {
    const [w, h] = [width, height].map(({ value }) => Math.round(numberOf(value)));
    return { width: w, height: h, scale: Number(scale.value) };
  }

  /** Say how large the file will be, in pixels. */
  function say() {
    const { width: w, height: h, scale: times } = asked();
    const isSize = w > 0 && h > 0;
    note.textContent = isSize
      ? `${w * times} × ${h * times} pixels`
      : "Width and height must be numbers of pixels";
    save.disabled = copy.disabled = !isSize;
  }

  /** The picture as a file; null, with the reason said, if it can't be made. @returns {Promise<Blob | null>} */
  async function make() {
    const sheet = element("canvas");
    const size = asked();
    const [w, h] = [size.width * size.scale, size.height * size.scale];
    /** @param {HTMLCanvasElement} picture */
    const take = (picture) => {
      Object.assign(sheet, { width: w, height: h });
      const context = sheet.getContext("2d");
      if (!context) return;
      if (!clear.checked) {
        context.fillStyle = BACKGROUND[shown.theme()];
        context.fillRect(0, 0, w, h);
      }
      context.drawImage(picture, 0, 0);
      if (legend && withLegend.checked)
        drawLegend(context, legend, size, clear.checked ? "light" : shown.theme());
    };
    try {
      send({ kind: "draw", ...size, take });
    } catch (error) {
      note.textContent = error instanceof Error ? error.message : String(error);
      return null;
    }
    return new Promise((resolve) => sheet.toBlob(resolve, "image/png"));
  }

  const show = (/** @type {boolean} */ isShown) => {
    if (panel.hidden !== isShown) return;
    panel.hidden = !isShown;
    if (!isShown) {
      leave();
      return;
    }
    const size = shown.size();
    [width.value, height.value] = [String(Math.round(size.width)), String(Math.round(size.height))];
    say();
    save.focus({ preventScroll: true });
  };
  panel.onsubmit = (event) => event.preventDefault();
  panel.oninput = say;
  panel.onchange = say;
  close.onclick = () => show(false);
  panel.onkeydown = (event) => {
    if (event.key === "Escape") show(false);
    else if (event.target !== width && event.target !== height) return;
    event.stopPropagation(); // digits are no levels here
  };
  save.onclick = async () => {
    const blob = await make();
    if (!blob) return;
    download(blob);
    note.textContent = `Saved as ${FILE}`;
  };
  copy.onclick = async () => {
    const blob = await make();
    if (!blob) return;
    try {
      await navigator.clipboard.write([new ClipboardItem({ "image/png": blob })]);
      note.textContent = "Copied";
    } catch {
      note.textContent = "This page may not copy pictures: save it instead";
    }
  };

  return {
    element: panel,
    show,
    isShown: () => !panel.hidden,

    /** @param {{ legend: import("./legend.js").Legend | null }} state */
    update(state) {
      legend = state.legend;
      legendField.hidden = legend === null;
    },
  };
}

/** @param {Blob} blob */
function download(blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: FILE });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
