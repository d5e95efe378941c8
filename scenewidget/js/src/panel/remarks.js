/** What Python says while it computes nothing is a remark: it shows for a moment. */

import { on } from "../wire/listen.js";

/** @param {Pick<import("../input/messages.js").Around, "model" | "send" | "signal">} around */
export function relayRemarks({ model, send, signal }) {
  let wasBusy = model.get("busy");
  const onStatus = () => {
    const isBusy = model.get("busy");
    if (!isBusy && !wasBusy) send({ kind: "remark", text: model.get("status") });
    else if (!wasBusy) send({ kind: "remark", text: "" }); // what came just before tells of this computation
    wasBusy = isBusy;
  };
  for (const name of ["status", "busy"]) on(model, `change:${name}`, onStatus, signal);
}
