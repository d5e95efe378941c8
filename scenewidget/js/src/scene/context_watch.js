/**
 * The graphics context of a picture, which the browser takes away when many 3D views are open.
 *
 * It may come back by itself. If it doesn't, a picture that was seen for a while, or that is scrolled into
 * sight, is made again; one that loses it soon is one of too many in sight, and left to a button.
 */

const ASIDE_MS = 4000; // without its context for so long, a view won't get it back by itself
const PATIENCE_MS = 5000; // a view that loses its context sooner is one of too many in sight

/**
 * @param {HTMLCanvasElement} canvas
 * @param {object} to
 * @param {(message: { kind: "lost" | "restored" | "state" }) => void} to.send  state: it won't come back by itself
 * @param {() => void} to.again  make the view again
 * @param {AbortSignal} signal
 */
export function watchContext(canvas, { send, again }, signal) {
  const began = performance.now();
  let isAside = false;
  let wasSeen = false;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const lost = () => {
    send({ kind: "lost" });
    clearTimeout(timer);
    timer = setTimeout(() => {
      isAside = true;
      if (wasSeen && performance.now() - began > PATIENCE_MS) again();
      else send({ kind: "state" });
    }, ASIDE_MS);
  };
  const restored = () => {
    clearTimeout(timer);
    isAside = false;
    send({ kind: "restored" });
  };
  canvas.addEventListener("webglcontextlost", lost, { signal });
  canvas.addEventListener("webglcontextrestored", restored, { signal });
  const scrolling = new IntersectionObserver(([{ isIntersecting }]) => {
    if (isIntersecting && !wasSeen && isAside) again();
    wasSeen = isIntersecting;
  });
  scrolling.observe(canvas);
  signal.addEventListener("abort", () => {
    scrolling.disconnect();
    clearTimeout(timer);
  });
  return { isAside: () => isAside };
}
