/** How far a computation is, and a button to end it. */

import { element, textButton } from "./elements.js";

/** @param {import("../input/messages.js").Send} send */
export function createProgress(send) {
  const bar = element("div", { class: "sw-bar" });
  const track = element(
    "div",
    { class: "sw-track", role: "progressbar", "aria-label": "Progress", hidden: "" },
    [bar],
  );
  const stage = element("span", { class: "sw-stage-name" });
  const cancel = textButton("Cancel");
  const box = element("div", { class: "sw-busy", role: "status", hidden: "" }, [stage, cancel]);
  cancel.onclick = () => {
    cancel.disabled = true;
    send({ kind: "cancel" });
  };
  return {
    track,
    element: box,

    /** @param {Pick<import("./state.js").PanelState, "busy" | "progress" | "status">} state  progress −1: unknown */
    update({ busy, progress, status }) {
      const isKnown = progress >= 0;
      const percent = Math.round(100 * progress);
      track.hidden = box.hidden = !busy;
      track.classList.toggle("sw-swinging", !isKnown);
      bar.style.width = isKnown ? `${100 * progress}%` : "";
      if (isKnown) track.setAttribute("aria-valuenow", String(percent));
      else track.removeAttribute("aria-valuenow");
      stage.textContent = [status || "Working", progress > 0 ? `${percent} %` : ""].join("  ");
      if (!busy) cancel.disabled = false;
    },
  };
}
