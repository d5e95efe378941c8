/** The line below the picture: what is pointed at, else how much there is; remarks; edits on their way. */

import { element } from "./elements.js";

const REMARK_MS = 5000;
const PENDING_MS = 300; // an answer that takes longer is told to be on its way

export function createStatusLine() {
  const swatch = element("span", { class: "sw-swatch", hidden: "" });
  const text = element("span", { class: "sw-status-text" });
  const remarkText = element("span", { class: "sw-remark", role: "status" });
  const pendingText = element("span", { class: "sw-pending", hidden: "" });
  const line = element("div", { class: "sw-status" }, [pendingText, swatch, remarkText, text]);
  let summary = "";
  let status = "";
  let hovered = /** @type {{ text: string, color: string | null } | null} */ (null);
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let remarkTimer;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let pendingTimer;

  function show() {
    const rest = [summary, remarkText.textContent ? "" : status].filter(Boolean).join("  ·  ");
    const next = hovered?.text ?? rest;
    if (text.textContent !== next) text.textContent = next; // even the same text would be drawn anew
    swatch.hidden = !hovered?.color;
    if (hovered?.color) swatch.style.background = hovered.color;
  }

  /** Say something for a few seconds, beside whatever else is shown. @param {string} words */
  function remark(words) {
    clearTimeout(remarkTimer);
    remarkText.textContent = words;
    if (words) remarkTimer = setTimeout(() => remark(""), REMARK_MS);
    show();
  }

  return {
    element: line,
    remark,

    /** @param {{ text: string, color: string | null } | null} words  of what is pointed at */
    hover(words) {
      hovered = words;
      show();
    },

    /** @param {Pick<import("./state.js").PanelState, "summary" | "status" | "busy" | "pending">} state */
    update(state) {
      summary = state.summary;
      status = state.busy ? "" : state.status;
      pendingText.textContent = state.pending === 1 ? "1 edit pending" : `${state.pending} edits pending`;
      if (state.pending === 0) {
        clearTimeout(pendingTimer);
        pendingTimer = undefined;
        pendingText.hidden = true;
      } else if (pendingTimer === undefined) {
        pendingTimer = setTimeout(() => {
          pendingText.hidden = false;
        }, PENDING_MS);
      }
      show();
    },
  };
}
