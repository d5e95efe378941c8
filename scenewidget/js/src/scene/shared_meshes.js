/**
 * Meshes that several views of a page draw: one of them has the arrays, the others know its name.
 *
 * Hosts load the bundle once a model, so what views share hangs on the page itself.
 */

import { readArray } from "../wire/wire.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {import("./renderer.js").MeshArrays & { up: string }} UprightMesh */

const NAME = Symbol.for("scenewidget.meshes");
const PATIENCE_MS = 4000; // then the other view isn't on this page, and Python has to send the arrays

/** @returns {{ meshes: Map<string, WeakRef<UprightMesh>>, news: EventTarget }} */
function shared() {
  const page = /** @type {any} */ (globalThis);
  page[NAME] ??= { meshes: new Map(), news: new EventTarget() };
  return page[NAME];
}

/** Let others draw it. @param {Model} model  that has the arrays @param {UprightMesh} mesh */
export function lend(model, mesh) {
  const name = model.get("_token");
  if (!name) return;
  const { meshes, news } = shared();
  for (const [other, ref] of meshes) if (!ref.deref()) meshes.delete(other);
  meshes.set(name, new WeakRef(mesh));
  news.dispatchEvent(new Event(name));
}

/** The mesh of another view, if it is there and stands as this model wants it. @param {Model} model */
export function borrowed(model) {
  const { meshes } = shared();
  const mesh = meshes.get(model.get("_mesh_of") ?? "")?.deref();
  return mesh?.up === String(model.get("_up") ?? [0, 0, 1]) ? mesh : null;
}

/**
 * Take the mesh of another view when it comes; where it doesn't, ask Python.
 * @param {Model} model
 * @param {() => void} take
 * @param {AbortSignal} signal
 */
export function awaitMesh(model, take, signal) {
  if (!model.get("_mesh_of")) return;
  shared().news.addEventListener(model.get("_mesh_of"), take, { signal });
  const timer = setTimeout(() => {
    if (!borrowed(model) && !readArray(model, "vertices")) model.send({ kind: "need_mesh" });
  }, PATIENCE_MS);
  signal.addEventListener("abort", () => clearTimeout(timer));
}
