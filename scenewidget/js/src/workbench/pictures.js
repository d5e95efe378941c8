/** Pictures of scans, fetched when they come into sight and kept as long as there is room. */

const MOST = 800; // that are kept
const WAIT_MS = 60; // so that a list that is scrolled past asks for nothing

/**
 * @param {{ ask: (scans: string[]) => void, show: (scan: string, url: string) => void }} around
 */
export function createPictures({ ask, show }) {
  /** @type {Map<string, string>} by scan: its address, "" while it is on its way or if there is none */
  const known = new Map();
  /** @type {string[]} */
  let wanted = [];
  let timer = 0;

  function forget(/** @type {string} */ scan) {
    const url = known.get(scan);
    if (url) URL.revokeObjectURL(url);
    known.delete(scan);
  }

  return {
    /** @param {string} scan */
    of: (scan) => known.get(scan) ?? "",

    /** These are in sight now. @param {string[]} scans */
    want(scans) {
      wanted = scans;
      clearTimeout(timer);
      timer = window.setTimeout(() => {
        const missing = wanted.filter((scan) => !known.has(scan));
        for (const scan of missing) known.set(scan, "");
        if (missing.length) ask(missing);
      }, WAIT_MS);
    },

    /** @param {string[]} scans @param {ArrayBufferView[]} contents */
    take(scans, contents) {
      scans.forEach((scan, k) => {
        forget(scan);
        const url = URL.createObjectURL(new Blob([/** @type {any} */ (contents[k])], { type: "image/jpeg" }));
        known.set(scan, url);
        show(scan, url);
      });
      for (const scan of known.keys()) {
        if (known.size <= MOST) break;
        if (!wanted.includes(scan)) forget(scan);
      }
    },

    forget,

    clear() {
      clearTimeout(timer);
      for (const scan of [...known.keys()]) forget(scan);
    },
  };
}
