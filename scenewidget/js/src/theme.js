/** Light or dark, as the page around is. */

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

/** @param {HTMLElement} element */
function isDarkAround(element) {
  const said = document.body.dataset.jpThemeLight;
  if (said) return said === "false";
  for (let node = element.parentElement; node; node = node.parentElement) {
    const [red, green, blue, alpha = 1] = (getComputedStyle(node).backgroundColor.match(/[\d.]+/g) ?? []).map(
      Number,
    );
    if (alpha > 0.5 && blue !== undefined) return 0.2126 * red + 0.7152 * green + 0.0722 * blue < 110;
  }
  return matchMedia("(prefers-color-scheme: dark)").matches;
}
