/** Light or dark, as the page around is. */

import { on } from "../wire/listen.js";

/**
 * Calls back now and whenever the host changes its theme.
 * @param {HTMLElement} element
 * @param {(isDark: boolean) => void} callback
 * @returns {() => void}  stop
 */
export function watchTheme(element, callback) {
  let last = /** @type {boolean | null} */ (null);
  const look = () => {
    const isDark = isDarkAround(element);
    if (isDark !== last) callback(isDark);
    last = isDark;
  };
  const later = () => requestAnimationFrame(look); // after the new style sheet has been applied
  const observer = new MutationObserver(later);
  for (const node of [document.documentElement, document.body]) observer.observe(node, { attributes: true });
  const media = matchMedia("(prefers-color-scheme: dark)");
  media.addEventListener("change", later);
  look();
  return () => {
    observer.disconnect();
    media.removeEventListener("change", later);
  };
}

/**
 * Show the theme that the model asks for, or that of the page.
 * @param {Pick<import("../input/messages.js").Around, "model" | "view" | "root" | "signal">} around
 */
export function showTheme({ model, view, root, signal }) {
  let isHostDark = false;
  const paint = () => {
    const theme = model.get("theme");
    const isDark = theme === "auto" ? isHostDark : theme === "dark";
    root.dataset.theme = isDark ? "dark" : "light";
    view.setLook({ isDark });
  };
  const stop = watchTheme(root, (isDark) => {
    isHostDark = isDark;
    paint();
  });
  on(model, "change:theme", paint, signal);
  signal.addEventListener("abort", stop);
}

/** What an element is in, also where that is the host of a shadow tree, as in marimo. @param {Element} element */
function around(element) {
  const root = element.getRootNode();
  return element.parentElement ?? (root instanceof ShadowRoot ? root.host : null);
}

/** @param {HTMLElement} element */
function isDarkAround(element) {
  const said = document.body.dataset.jpThemeLight;
  if (said) return said === "false";
  for (let node = around(element); node; node = around(node)) {
    const [red, green, blue, alpha] = bytesOf(getComputedStyle(node).backgroundColor);
    if (alpha > 127) return 0.2126 * red + 0.7152 * green + 0.0722 * blue < 110;
  }
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

/** @type {CanvasRenderingContext2D | null} */
let pixel = null;

/** Red, green, blue and alpha from 0 to 255 of a colour in any notation of CSS. @param {string} color */
function bytesOf(color) {
  pixel ??= document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  if (!pixel) return [0, 0, 0, 0];
  pixel.clearRect(0, 0, 1, 1);
  pixel.fillStyle = color;
  pixel.fillRect(0, 0, 1, 1);
  return [...pixel.getImageData(0, 0, 1, 1).data];
}
