/** What went wrong in a computation, until it is dismissed. */

import { element, textButton } from "./elements.js";

/** @param {import("../input/messages.js").Send} send */
export function createErrorBar(send) {
  const text = element("div", { class: "sw-error-text" });
  const dismiss = textButton("Dismiss");
  const bar = element("div", { class: "sw-error", role: "alert", hidden: "" }, [text, dismiss]);
  dismiss.onclick = () => send({ kind: "set", name: "error", value: "" });
  return {
    element: bar,
    /** @param {{ error: string }} state */
    update({ error }) {
      text.textContent = error;
      bar.hidden = error === "";
    },
  };
}
