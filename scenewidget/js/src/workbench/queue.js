/** Which scans the queue shows, in which order, and which of them are in sight. Knows no page. */

/**
 * A scan as Python tells of it.
 * @typedef {object} Row
 * @property {string} scan
 * @property {"new" | "begun" | "review" | "done" | "failed"} state
 * @property {number | null} doubt  share of the surface that is probably wrong
 * @property {number | null} faces
 * @property {number | null} segments
 * @property {number} edits
 * @property {number} seconds  of work
 * @property {string[]} people
 * @property {string} error
 * @property {number | null} before  error of the automatic answer against the truth
 * @property {number | null} now  the same after the last correction
 */

export const STATES = /** @type {const} */ (["new", "begun", "review", "done", "failed"]);
export const STATE_NAMES = {
  new: "New",
  begun: "Begun",
  review: "To review",
  done: "Done",
  failed: "Failed",
};

/** Of each order: what it is called, and what it goes by, from large to small. */
export const ORDERS = {
  doubt: { name: "Most doubtful first", by: (/** @type {Row} */ row) => row.doubt ?? -1 },
  error: { name: "Largest error first", by: (/** @type {Row} */ row) => row.now ?? row.before ?? -1 },
  faces: { name: "Largest first", by: (/** @type {Row} */ row) => row.faces ?? -1 },
  work: { name: "Longest worked on first", by: (/** @type {Row} */ row) => row.seconds },
  name: { name: "By name", by: () => 0 },
};

/** @typedef {keyof typeof ORDERS} Order */

/** @param {Row[]} rows */
export function countStates(rows) {
  /** @type {Record<string, number>} */
  const counts = Object.fromEntries(STATES.map((state) => [state, 0]));
  for (const row of rows) counts[row.state] += 1;
  return counts;
}

/**
 * @param {Row[]} rows
 * @param {{ state: string, text: string, order: Order }} wish  `state` "" for all; `text` must be in the name or
 *   among the people, whatever the case
 */
export function chosenRows(rows, { state, text, order }) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const { by } = ORDERS[order];
  return rows
    .filter((row) => state === "" || row.state === state)
    .filter((row) => {
      const hay = `${row.scan} ${row.people.join(" ")}`.toLowerCase();
      return words.every((word) => hay.includes(word));
    })
    .sort((a, b) => by(b) - by(a) || (a.scan < b.scan ? -1 : 1));
}

/**
 * The rows that are in sight, and a few around them.
 * @param {{ n: number, top: number, height: number, rowHeight: number }} list
 * @returns {[number, number]}  first, and one after the last
 */
export function inSight({ n, top, height, rowHeight }) {
  const first = Math.max(0, Math.floor(top / rowHeight) - 3);
  return [Math.min(first, n), Math.min(n, Math.ceil((top + height) / rowHeight) + 3)];
}

/**
 * Where to scroll so that a row is in sight; the same place if it is.
 * @param {number} index
 * @param {{ top: number, height: number, rowHeight: number }} list
 */
export function scrolledTo(index, { top, height, rowHeight }) {
  const start = index * rowHeight;
  if (start < top) return start;
  return start + rowHeight > top + height ? start + rowHeight - height : top;
}

/** Seconds of work as people say them. @param {number} seconds */
export function spokenTime(seconds) {
  if (seconds < 60) return `${Math.round(seconds)} s`;
  return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

/** A number of faces, short. @param {number} n */
export function spokenCount(n) {
  if (n < 10_000) return String(n);
  return n < 1_000_000 ? `${Math.round(n / 1000)} k` : `${(n / 1_000_000).toFixed(1)} M`;
}

/**
 * Scans to try, one after the other, when a person wants the next one (or the one before): those that follow the
 * current one as the list stands, then those from its beginning.
 * @param {Row[]} rows  as shown
 * @param {string} current
 * @param {number} step  1 or -1
 */
export function candidates(rows, current, step) {
  const names = rows.filter((row) => row.state !== "failed").map((row) => row.scan);
  const at = names.indexOf(current);
  if (step < 0) return at < 0 ? [] : names.slice(0, at).reverse();
  return at < 0 ? names : [...names.slice(at + 1), ...names.slice(0, at)];
}
