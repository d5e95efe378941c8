/** What a model holds, in the forms in which a view takes it. */

import { counted } from "./description.js";
import { boundingBall, vertexNormals } from "./geometry.js";
import { countSegments } from "./partition.js";
import { upright } from "./upright.js";
import { readArray } from "./wire.js";

/** @typedef {import("./wire.js").Model} Model */
/** @typedef {import("./renderer.js").MeshArrays} MeshArrays */
/** @typedef {import("./viewer.js").Viewer} Viewer */

/** Arrays as drawn, shared by all views of a model. @type {WeakMap<Model, MeshArrays & { up: string }>} */
const meshes = new WeakMap();

/**
 * @param {Model} model
 * @returns {MeshArrays | null}
 */
export function readMesh(model) {
  const known = meshes.get(model);
  const up = model.get("_up") ?? [0, 0, 1];
  if (known?.up === String(up)) return known;
  const given = /** @type {Float32Array | null} */ (readArray(model, "vertices"));
  const faces = /** @type {Uint32Array | null} */ (readArray(model, "faces"));
  const colors = /** @type {Uint8Array | null} */ (readArray(model, "vertex_colors"));
  if (!given || !faces) return null;
  const vertices = upright(given, up);
  const [normals, bounds] = [vertexNormals(vertices, faces), boundingBall(vertices)];
  const mesh = { vertices, faces, colors, normals, bounds, up: String(up) };
  meshes.set(model, mesh);
  return mesh;
}

/** What the picture shows, in numbers. @param {Viewer} view */
export function summaryOf(view) {
  if (!view.mesh) return "";
  const n = view.partition ? countSegments(view.partition.atomSegment) : 0;
  return [counted(view.mesh.faces.length / 3, "face"), view.partition ? counted(n, "segment") : ""]
    .filter(Boolean)
    .join("  ·  ");
}

/** How many segments are hidden, at least in part. @param {Viewer} view */
export function hiddenSegments({ hidden, partition }) {
  if (!hidden || !partition) return 0;
  return new Set(partition.atomSegment.filter((_, atom) => hidden[atom] === 1)).size;
}

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
