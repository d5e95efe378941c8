/** Whether the kernel is still there. Without it one can look, but an edit would be lost without a word. */

import { watchKernel } from "./kernel.js";
import { on } from "./listen.js";

const GONE = "jupyter-widgets-disconnected"; // Jupyter's mark of a view whose kernel has gone
const LEVELS = 4; // of elements around a view, one of which gets the mark

/** @typedef {ReturnType<typeof watchConnection>} Connection */

/**
 * @param {import("./wire.js").Model} model
 * @param {HTMLElement} host
 * @param {() => void} onChange
 * @param {AbortSignal} signal
 */
export function watchConnection(model, host, onChange, signal) {
  const isMarked = () => host.closest(`.${GONE}`) !== null;
  let wasMarked = isMarked();
  const check = () => {
    if (isMarked() === wasMarked) return;
    wasMarked = !wasMarked;
    onChange();
  };
  const observer = new MutationObserver(check);
  /** @type {HTMLElement | null} */
  let node = host;
  for (let level = 0; node && level < LEVELS; level++, node = node.parentElement) {
    observer.observe(node, { attributes: true, attributeFilter: ["class"] });
  }
  on(model, "comm_live_update", () => setTimeout(check), signal);
  signal.addEventListener("abort", () => observer.disconnect());
  const kernel = watchKernel(model.widget_manager, onChange, signal);
  return {
    isLive: () => !wasMarked && kernel.state() === "there",
    /** Whether it may come back by itself. */
    isCutOff: () => !wasMarked && kernel.state() === "cut off",
  };
}
