/**
 * Whether a kernel is there, as Jupyter's own objects know it.
 *
 * Jupyter marks a view whose kernel it restarts itself. One that is shut down, killed or deleted, by whomever,
 * leaves no mark, so look at it, and while the line to it is cut, ask the server.
 */

const LOOK_MS = 1000;
const CUT_MS = 2500; // a line that is cut for so long is told of
const ENDED = ["restarting", "autorestarting", "terminating", "dead"]; // what was there before is no more

/** @typedef {"there" | "gone" | "cut off"} KernelState  gone: for ever; cut off: for now */

/**
 * @param {any} manager  of the widgets, as Jupyter gives it to a model; undefined elsewhere
 * @param {() => void} onChange
 * @param {AbortSignal} signal
 * @returns {{ state: () => KernelState }}
 */
export function watchKernel(manager, onChange, signal) {
  /** @type {any} */
  let kernel = null;
  /** @type {KernelState} */
  let state = "there";
  let cutSince = /** @type {number | null} */ (null);
  let isAsking = false;

  /** @param {KernelState} next */
  function set(next) {
    if (next === state || state === "gone") return;
    state = next;
    onChange();
  }

  const onStatus = (/** @type {unknown} */ _, /** @type {string} */ status) => {
    if (ENDED.includes(status)) set("gone");
  };

  /** @param {any} next  null = none */
  function follow(next) {
    kernel?.statusChanged?.disconnect(onStatus);
    kernel = next;
    kernel?.statusChanged?.connect(onStatus);
  }

  function look() {
    const now = manager?.kernel ?? null;
    if (kernel && now?.id !== kernel.id) set("gone");
    else if (now !== kernel) follow(now);
    if (kernel?.isDisposed || ENDED.includes(kernel?.status)) set("gone");
    if (kernel && state !== "gone") lookAtLine();
  }

  function lookAtLine() {
    const isCut = typeof kernel.connectionStatus === "string" && kernel.connectionStatus !== "connected";
    if (!isCut) {
      cutSince = null;
      set("there");
      return;
    }
    cutSince ??= Date.now();
    if (Date.now() - cutSince >= CUT_MS) set("cut off");
    if (!isAsking) ask(kernel);
  }

  /** Whether the server still knows it. @param {any} asked */
  async function ask({ id, serverSettings }) {
    if (!serverSettings?.baseUrl) return;
    isAsking = true;
    try {
      const { baseUrl, token } = serverSettings;
      const headers = token ? { Authorization: `token ${token}` } : undefined;
      const answer = await fetch(`${baseUrl}api/kernels/${encodeURIComponent(id)}`, { headers });
      if (answer.status === 404 && !signal.aborted) set("gone");
    } catch {
      // no server either: cut off
    }
    isAsking = false;
  }

  if (manager) {
    look();
    const timer = setInterval(look, LOOK_MS);
    signal.addEventListener("abort", () => {
      clearInterval(timer);
      follow(null);
    });
  }
  return { state: () => state };
}
