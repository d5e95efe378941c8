/** The wheel zooms, unless it is scrolling the page: a scroll that began outside goes on doing so. */

import { placeOn } from "./place.js";

const SCROLL_PAUSE_MS = 200;
const LINE = 16; // pixels
const MOST = 0.5; // of one event

/**
 * @param {{ canvas: HTMLCanvasElement, send: import("./messages.js").Send, signal: AbortSignal }} around
 */
export function listenToWheel({ canvas, send, signal }) {
  let lastScroll = -Infinity;
  /** @param {WheelEvent} event */
  const onWheel = (event) => {
    const isInside = event.composedPath().includes(canvas);
    const isPassing = event.timeStamp - lastScroll < SCROLL_PAUSE_MS && !event.ctrlKey;
    if (!isInside || isPassing) {
      lastScroll = event.timeStamp;
      return;
    }
    event.preventDefault();
    event.stopPropagation();
    send({ kind: "zoom", factor: zoomFactor(event), ...placeOn(canvas, event) });
  };
  window.addEventListener("wheel", onWheel, { signal, passive: false, capture: true });
}

/**
 * How much nearer or farther one event leads. With Ctrl it is the pinch of a touch pad, which counts in small steps.
 * @param {{ deltaY: number, deltaMode: number, ctrlKey: boolean }} event
 */
export function zoomFactor({ deltaY, deltaMode, ctrlKey }) {
  const pixels = deltaY * (deltaMode === 1 ? LINE : 1);
  return Math.exp(Math.max(-MOST, Math.min(MOST, pixels * (ctrlKey ? 0.01 : 0.0018))));
}
