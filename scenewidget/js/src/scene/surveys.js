/** Surfaces that brushes walk on, looked at while the page rests; all views of a mesh share one. */

import { survey } from "./surface.js";

/** @typedef {import("./surface.js").Surface} Surface */

const PAUSE_MS = 8; // between two slices of work

/** @type {WeakMap<object, { begin: () => void, surface: () => Surface }>} */
const known = new WeakMap();

/** @param {Parameters<typeof survey>[0]} mesh */
export function surveyOf(mesh) {
  let own = known.get(mesh);
  if (!own) {
    own = createSurvey(mesh);
    known.set(mesh, own);
  }
  return own;
}

/** @param {Parameters<typeof survey>[0]} mesh */
function createSurvey(mesh) {
  const work = survey(mesh);
  /** @type {Surface | null} */
  let found = null;
  let hasBegun = false;
  const step = () => {
    const { done, value } = work.next();
    if (done) found = value;
    return found;
  };
  const proceed = () => {
    if (!found && !step()) setTimeout(proceed, PAUSE_MS);
  };
  return {
    /** Begin to look, so that the surface is there when it is wanted. */
    begin() {
      if (hasBegun) return;
      hasBegun = true;
      setTimeout(proceed, PAUSE_MS);
    },

    /** The surface; what hasn't been looked at yet is, at once. */
    surface() {
      for (;;) {
        const surface = found ?? step();
        if (surface) return surface;
      }
    },
  };
}
