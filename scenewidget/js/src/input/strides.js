/** Walks on while keys are held down. */

/** @typedef {import("../scene/walk.js").Way} Way */

const FIRST_SECONDS = 0.08; // that a tap counts for at least
const LONGEST_SECONDS = 0.15; // of a slow frame

/** @param {import("../scene/viewer.js").Viewer} view */
export function createStrides(view) {
  /** @type {Set<Way>} */
  const ways = new Set();
  let request = 0;
  let last = 0;

  const go = (/** @type {number} */ now) => {
    request = 0;
    if (ways.size === 0) return;
    view.walk(ways, Math.min(LONGEST_SECONDS, (now - last) / 1000));
    last = now;
    request = requestAnimationFrame(go);
  };

  return {
    /** @param {Way} way */
    start(way) {
      if (ways.has(way)) return;
      ways.add(way);
      view.walk([way], FIRST_SECONDS);
      last = performance.now();
      if (request === 0) request = requestAnimationFrame(go);
    },

    /** @param {Way} [way]  all of them by default */
    stop(way) {
      if (way) ways.delete(way);
      else ways.clear();
    },
  };
}
