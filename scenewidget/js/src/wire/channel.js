/** Messages between the widgets on one page, without the kernel: each has a channel, and those on it hear it. */

const EVENT = "scenewidget-channel";

/**
 * @param {string} channel  "" reaches nobody
 * @param {object} message
 */
export function post(channel, message) {
  if (channel) window.dispatchEvent(new CustomEvent(EVENT, { detail: { channel, message } }));
}

/**
 * @param {() => string} channel  asked for at each message, since it may change
 * @param {(message: any) => void} callback
 * @param {AbortSignal} signal  ends it
 */
export function hear(channel, callback, signal) {
  const onMessage = (/** @type {Event} */ event) => {
    const { channel: sent, message } = /** @type {CustomEvent} */ (event).detail;
    if (sent && sent === channel()) callback(message);
  };
  window.addEventListener(EVENT, onMessage, { signal });
}
