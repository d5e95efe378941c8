/** A view without Python: a saved page brings its state along and a stand-in for the model. */

/** @typedef {import("./wire.js").Model} Model */
/** @typedef {{ dtype: string, shape: number[], data: string }} PackedArray  bytes as base64 of gzip */

/**
 * The part of a model that a view uses; what it sets stays on the page, what it sends goes nowhere.
 * @param {Record<string, unknown>} state
 * @returns {Model}
 */
export function standIn(state) {
  const values = { ...state };
  /** @type {Map<string, Set<(...args: any[]) => void>>} */
  const listeners = new Map();
  return {
    get: (name) => values[name],
    set(name, value) {
      if (values[name] === value) return;
      values[name] = value;
      for (const callback of [...(listeners.get(`change:${name}`) ?? [])]) callback();
    },
    save_changes() {},
    send() {},
    on(event, callback) {
      listeners.set(event, (listeners.get(event) ?? new Set()).add(callback));
    },
    off(event, callback) {
      listeners.get(event)?.delete(callback);
    },
  };
}

/**
 * The model of a saved page.
 * @param {{ state: Record<string, unknown>, arrays: Record<string, PackedArray> }} saved
 */
export async function savedModel({ state, arrays }) {
  const names = Object.keys(arrays);
  const bytes = await Promise.all(names.map((name) => unpacked(arrays[name].data)));
  const headers = names.map((name) => [name, { dtype: arrays[name].dtype, shape: arrays[name].shape }]);
  return standIn({
    ...state,
    ...Object.fromEntries(names.map((name, i) => [`_${name}`, bytes[i]])),
    _headers: Object.fromEntries(headers),
  });
}

/** @param {string} text */
async function unpacked(text) {
  const characters = atob(text);
  const packed = new Uint8Array(characters.length); // Uint8Array.from takes ten times as long
  for (let i = 0; i < packed.length; i++) packed[i] = characters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
