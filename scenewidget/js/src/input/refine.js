/**
 * A segment made a ring larger or smaller, without its holes or the teeth of its border. Python knows how: while a
 * button is pointed at, it is asked what would change hands, and that lights up.
 */

import { facesOf } from "../labels/offcut.js";
import { on as listenTo } from "../wire/listen.js";
import { asBytes } from "../wire/wire.js";

/**
 * @param {Pick<import("./messages.js").Around, "model" | "segments" | "send" | "on" | "signal"> & {
 *   picked: () => { face: number } | null,
 * }} around
 */
export function createRefine({ model, segments, picked, send, on, signal }) {
  const me = Math.random().toString(36).slice(2, 8);
  let n = 0;
  /** The question whose answer is waited for. */
  let asked = "";

  function clear() {
    asked = "";
    if (segments.offcut === null) return;
    segments.cutOff([]);
    send({ kind: "segments" });
  }

  const onMessage = (/** @type {any} */ message, /** @type {any[]} */ buffers) => {
    if (message?.kind !== "edit_preview" || message.request !== asked) return;
    asked = "";
    segments.cutOff(facesOf(message.first, asBytes(buffers[0])));
    send({ kind: "segments" });
    if (message.reason) send({ kind: "remark", text: message.reason });
  };
  listenTo(model, "msg:custom", onMessage, signal);

  on({
    refine({ how }) {
      const face = picked()?.face;
      clear();
      if (face !== undefined) send({ kind: "edit", edit: { kind: how, face } });
    },
    refine_preview({ how }) {
      const face = picked()?.face;
      clear();
      if (how === null || face === undefined || segments.pending.operations.length > 0) return;
      asked = `${me}${++n}`;
      const edit = { kind: how, face };
      model.send({ kind: "preview_edit", request: asked, edit, revision: model.get("revision") });
    },
  });
}
