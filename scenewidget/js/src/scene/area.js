/** A part of the picture that is drawn again while the rest stays as it is. */

/** @typedef {import("../labels/shown_segments.js").Area} Area */

const MARGIN = 4; // CSS pixels: outlines lie beside what they part

/** What holds nothing yet. @returns {Area} */
export function nowhere() {
  return { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
}

/** Let an area hold a place. @param {Area} area @param {{ x: number, y: number }} place */
export function widen(area, { x, y }) {
  area.left = Math.min(area.left, x);
  area.top = Math.min(area.top, y);
  area.right = Math.max(area.right, x);
  area.bottom = Math.max(area.bottom, y);
}

/**
 * What holds both; null = all of the picture.
 * @param {Area | null} a
 * @param {Area | null} b
 * @returns {Area | null}
 */
export function joined(a, b) {
  if (!a || !b) return null;
  return {
    left: Math.min(a.left, b.left),
    top: Math.min(a.top, b.top),
    right: Math.max(a.right, b.right),
    bottom: Math.max(a.bottom, b.bottom),
  };
}

/**
 * As WebGL cuts a picture: whole pixels from the lower left.
 * @param {Area} area
 * @param {number} ratio  pixels a CSS pixel
 * @param {{ width: number, height: number }} size  pixels
 * @returns {[x: number, y: number, width: number, height: number]}
 */
export function scissor({ left, top, right, bottom }, ratio, { width, height }) {
  const x = Math.max(0, Math.floor((left - MARGIN) * ratio));
  const end = Math.min(width, Math.ceil((right + MARGIN) * ratio));
  const upper = Math.max(0, Math.floor((top - MARGIN) * ratio));
  const lower = Math.min(height, Math.ceil((bottom + MARGIN) * ratio));
  return [x, height - lower, Math.max(0, end - x), Math.max(0, lower - upper)];
}
