/** Views that look the same way and point at the same place: those on a page with the same `camera_group`. */

import { element } from "../panel/elements.js";
import { hear, post } from "../wire/channel.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */

/**
 * @param {object} around
 * @param {import("../wire/wire.js").Model} around.model
 * @param {import("../scene/viewer.js").Viewer} around.view
 * @param {ReturnType<typeof import("../panel/panel.js").createPanel>} around.panel
 * @param {AbortSignal} around.signal
 * @param {(face: number | null) => void} showFace  that another view points at
 */
export function createLinking({ model, view, panel, signal }, showFace) {
  const me = Math.random().toString(36).slice(2, 10);
  const channel = () => model.get("camera_group") ?? "";
  const dot = element("div", { class: "sw-twin", "aria-hidden": "true", hidden: "" });
  panel.canvas.after(dot);
  /** Where another view points. @type {Vec3 | null} */
  let point = null;
  let isTold = false;

  function place() {
    const at = point && view.placeOf(point);
    dot.hidden = !at;
    if (at) dot.style.transform = `translate(${at.x}px, ${at.y}px)`;
  }

  const onMessage = (/** @type {any} */ { kind, from, camera, face, point: there }) => {
    if (from === me) return;
    if (kind === "camera") view.follow(camera);
    else if (kind === "point") {
      point = there;
      place();
      showFace(face);
    }
  };
  hear(channel, onMessage, signal);

  return {
    place,

    /** The camera has been moved here. @param {import("../scene/camera.js").Camera} camera */
    moved(camera) {
      post(channel(), { kind: "camera", from: me, camera });
    },

    /** The pointer is on a face here, or on none. @param {number | null} face @param {Vec3 | null} at */
    pointed(face, at) {
      if (face === null && !isTold) return;
      isTold = face !== null;
      post(channel(), { kind: "point", from: me, face, point: at });
    },
  };
}
