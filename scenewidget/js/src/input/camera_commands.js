/** Wishes about where one looks from, and what of the scan is cut away. */

import { WHOLE } from "../scene/section.js";
import { on as onModel } from "../wire/listen.js";
import { createStrides } from "./strides.js";

/** @param {Pick<import("./messages.js").Around, "model" | "view" | "send" | "on" | "signal">} around */
export function createCameraCommands({ model, view, send, on, signal }) {
  const strides = createStrides(view);
  const section = (/** @type {import("../scene/section.js").Range[]} */ value) =>
    send({ kind: "set", name: "section", value });
  on({
    orbit: (action) => view.apply(action),
    pan: (action) => view.apply(action),
    zoom: (action) => view.apply({ x: view.size.width / 2, y: view.size.height / 2, ...action }),
    look: ({ from }) => view.lookFrom(from),
    walk: ({ way }) => strides.start(way),
    draw: ({ take, ...size }) => view.drawAt(size, take),
    cut_ceiling: () => section(view.openedAbove),
    toggle({ what }) {
      if (what === "inside") view.goInside(!view.isInside);
      else if (what === "ceiling") section(view.isCut ? WHOLE : view.openedAbove);
    },
  });
  const onMessage = (/** @type {any} */ message) => {
    if (message?.kind === "look") view.lookFrom(message.from);
  };
  onModel(model, "msg:custom", onMessage, signal);
  signal.addEventListener("abort", () => strides.stop());
  return { strides };
}
