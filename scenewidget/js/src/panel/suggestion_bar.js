/** One edit at a time that the ensemble would like to have judged: framed, lit, and done or passed over. */

import { hear } from "../wire/channel.js";
import { on as onModel } from "../wire/listen.js";
import { element, iconButton, textButton } from "./elements.js";

/**
 * @param {import("../input/messages.js").Around & {
 *   connection: Pick<import("../wire/connection.js").Connection, "isLive">,
 * }} around
 * @param {HTMLElement} dock
 */
export function createSuggestionBar({ model, view, segments, root, connection, send, on, signal }, dock) {
  const text = element("span", { class: "sw-picked-text" });
  const why = element("span", { class: "sw-picked-why" });
  const progress = element("span", { class: "sw-picked-why", role: "status" });
  const accept = textButton("Accept", "Do this (Enter)");
  const skip = textButton("Skip", "Don't suggest this again (K)");
  const close = iconButton("close", "Stop suggesting", "Esc");
  const bar = element(
    "div",
    { class: "sw-picked sw-suggestion", role: "toolbar", "aria-label": "Suggestion", hidden: "" },
    [text, why, accept, skip, close, progress],
  );
  dock.append(bar);
  let shown = /** @type {any} */ ({});
  let isWaiting = false; // for Python's answer

  /** @param {"next" | "accept" | "skip" | "close" | "names"} what */
  function tell(what) {
    if (segments.isPreview || (isWaiting && what !== "close")) return;
    isWaiting = true;
    model.send({ kind: "suggest", do: what, number: shown.number ?? 0 });
  }

  function show() {
    shown = (connection.isLive() && model.get("suggestion")) || {};
    isWaiting = false;
    const isThere = shown.title !== undefined;
    if (bar.hidden === isThere && !isThere && bar.contains(document.activeElement))
      root.focus({ preventScroll: true });
    bar.hidden = !isThere;
    root.dataset.suggestion = isThere ? shown.kind : "";
    text.textContent = shown.title ?? "";
    why.textContent = shown.why ?? "";
    progress.textContent = shown.progress ?? "";
    segments.suggested = shown.faces ?? [];
    send({ kind: "segments" });
    send({ kind: "suggested", edit: isThere ? { face: shown.face, onto: shown.onto_face } : null });
  }

  function showNext() {
    const { number } = shown;
    show();
    if (bar.hidden || shown.number === number) return;
    if (model.get("level") !== shown.level) {
      send({ kind: "set", name: "level", value: shown.level });
    }
    queueMicrotask(() => view.lookAround(shown.face)); // once the parts are those of the level
  }

  accept.onclick = () => tell("accept");
  skip.onclick = () => tell("skip");
  close.onclick = () => tell("close");
  const onKey = (/** @type {KeyboardEvent} */ event) => {
    const { target } = event;
    if (target !== root && !(target instanceof Node && bar.contains(target))) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase();
    const isThere = !bar.hidden;
    const meant =
      key === "k" && isThere
        ? "skip"
        : key === "k" && model.get("editable") && connection.isLive()
          ? "next"
          : key === "enter" && isThere && target === root // a button does its own
            ? "accept"
            : key === "escape" && isThere
              ? "close"
              : null;
    if (!meant) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    tell(meant);
  };
  root.addEventListener("keydown", onKey, { signal, capture: true });
  onModel(model, "change:suggestion", showNext, signal);
  const onMessage = (/** @type {any} */ message) => {
    if (message.kind !== "suggest") return;
    tell(message.what);
    root.focus({ preventScroll: true });
  };
  hear(() => model.get("_channel"), onMessage, signal);
  on({ state: () => connection.isLive() || bar.hidden || show() }); // without a kernel nothing can be done of it
  show();
}
