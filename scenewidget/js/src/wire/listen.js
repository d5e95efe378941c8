/** Hears when pieces of a model's state change. */

/** @typedef {import("./wire.js").Model} Model */

/**
 * Calls back when pieces of state have changed. Changes arrive one by one, also those that belong together:
 * they are taken all at once, when they are in.
 * @template {string} Name
 * @param {Model} model
 * @param {Record<Name, string[]>} groups  names of the pieces of state, by what is taken with them
 * @param {(groups: Set<Name>) => void} take
 * @param {AbortSignal} signal
 */
export function listen(model, groups, take, signal) {
  /** @type {Set<Name>} */
  const changes = new Set();
  const takeChanges = () => {
    if (signal.aborted) return;
    const taken = new Set(changes);
    changes.clear();
    take(taken);
  };
  for (const group of /** @type {Name[]} */ (Object.keys(groups))) {
    const callback = () => {
      if (changes.size === 0) queueMicrotask(takeChanges);
      changes.add(group);
    };
    for (const name of groups[group]) on(model, `change:${name}`, callback, signal);
  }
}

/**
 * @param {Model} model
 * @param {string} event
 * @param {(...args: any[]) => void} callback
 * @param {AbortSignal} signal  ends it
 */
export function on(model, event, callback, signal) {
  model.on(event, callback);
  signal.addEventListener("abort", () => model.off(event, callback));
}
