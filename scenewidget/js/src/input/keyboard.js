/** Key presses on a view: finds what each means and says so. */

import { command, wayOf } from "./keys.js";

/**
 * @param {import("./messages.js").Around & {
 *   aim: import("./aim.js").Aim,
 *   strides: ReturnType<typeof import("./strides.js").createStrides>,
 *   closing: Array<() => boolean>,
 * }} around  closing: what Escape closes, the first that is open; each says whether it was
 */
export function listenToKeys({ model, view, root, aim, strides, closing, send, signal }) {
  /** @param {KeyboardEvent} event */
  const onKey = (event) => {
    const target = event.target instanceof HTMLElement ? event.target : root;
    if (target.matches("select, input") && event.key !== "Escape") return;
    if (target.matches("button") && (event.key === "Enter" || event.key === " ")) return;
    const wish = command(event, model.get("mode"), view.isInside);
    if (!wish || (wish.kind === "save" && !model.get("editable"))) return;
    event.preventDefault();
    event.stopPropagation();
    aim.showCross(target === root);
    if (wish.kind === "escape") closing.some((close) => close());
    else send(wish);
  };
  root.addEventListener("keydown", onKey, { signal });
  root.addEventListener("keyup", (event) => strides.stop(wayOf(event.key)), { signal });
  root.addEventListener("focusout", () => strides.stop(), { signal });
}
