/** Views that look the same way and point at the same place: those on a page with the same `camera_group`. */

import { hear, post } from "../wire/channel.js";

/** @typedef {import("../scene/camera.js").Vec3} Vec3 */

/** @param {Pick<import("./messages.js").Around, "model" | "view" | "send" | "on" | "signal">} around */
export function createLinkedViews({ model, view, send, on, signal }) {
  const me = Math.random().toString(36).slice(2, 10);
  const channel = () => model.get("camera_group") ?? "";
  /** Where another view points. @type {Vec3 | null} */
  let point = null;
  let isTold = false;

  const place = () => send({ kind: "twin", place: point && view.placeOf(point) });
  const onMessage = (/** @type {any} */ { kind, from, camera, face, point: there }) => {
    if (from === me) return;
    if (kind === "camera") view.follow(camera);
    else if (kind === "point") {
      point = there;
      place();
      send({ kind: "twin_pointed", face });
    }
  };
  hear(channel, onMessage, signal);

  on({
    moving: place,
    rested: place,
    moved: ({ camera }) => post(channel(), { kind: "camera", from: me, camera }),
    pointed({ face, at }) {
      if (face === null && !isTold) return;
      isTold = face !== null;
      post(channel(), { kind: "point", from: me, face, point: at });
    },
  });
}
