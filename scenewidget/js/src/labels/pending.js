/** Edits on their way to Python and back: what all views of a model on a page show as if it were done. */

/** @typedef {import("./prediction.js").Operation} Operation */

/**
 * Operations on their way to Python and back. Each has a number; `answered` says up to which one Python is through.
 */
export class Pending {
  /** @param {string} client  tells the pages apart that show the same view */
  constructor(client) {
    this.client = client;
    this.last = 0;
    /** @type {Array<{ number: number, operation: Operation, since: number }>} */
    this.waiting = [];
    /** Called when operations have come or gone, by every view of the page. @type {Set<() => void>} */
    this.watchers = new Set();
  }

  /** @returns {Operation[]} */
  get operations() {
    return this.waiting.map(({ operation }) => operation);
  }

  /**
   * Remember an operation; gives what has to go along with it.
   * @param {Operation} operation
   */
  add(operation) {
    this.waiting.push({ number: ++this.last, operation, since: Date.now() });
    for (const watcher of this.watchers) watcher();
    return { client: this.client, number: this.last };
  }

  /**
   * Forget what Python has answered.
   * @param {Record<string, number> | undefined} answers  number by client
   */
  answered(answers) {
    const through = answers?.[this.client] ?? 0;
    this.waiting = this.waiting.filter(({ number }) => number > through);
  }

  /** Show them no longer; Python may still do them. */
  forget() {
    this.waiting = [];
    for (const watcher of this.watchers) watcher();
  }

  /** Milliseconds since the oldest one was sent; 0 if there is none. */
  get age() {
    return this.waiting.length > 0 ? Date.now() - this.waiting[0].since : 0;
  }
}

/** @returns {Map<string, Pending>} */
function registry() {
  const page = /** @type {any} */ (globalThis);
  const key = Symbol.for("scenewidget.pending");
  page[key] ??= new Map();
  return page[key];
}

/**
 * The operations of one model, shared by all its views on a page: each shows what the others have sent.
 * @param {string} token  of the model; "" = shares with none
 */
export function pendingOf(token) {
  const known = registry().get(token);
  if (token && known) return known;
  const pending = new Pending(Math.random().toString(36).slice(2, 10));
  if (token) registry().set(token, pending);
  return pending;
}
