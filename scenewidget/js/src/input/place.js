/** Where on a picture something happens. */

/**
 * Pixels of the picture from its upper left, also where the page shows it larger or smaller than it is laid out,
 * as slides do.
 * @param {{ getBoundingClientRect: () => { left: number, top: number, width: number, height: number },
 *   clientWidth: number, clientHeight: number }} canvas
 * @param {{ clientX: number, clientY: number }} event
 * @returns {import("./gestures.js").Place}
 */
export function placeOn(canvas, { clientX, clientY }) {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  return {
    x: ((clientX - left) * canvas.clientWidth) / (width || 1),
    y: ((clientY - top) * canvas.clientHeight) / (height || 1),
  };
}
