/** The scan as a model holds it, as arrays to draw. */

import { readArray } from "../wire/wire.js";
import { boundingBall, vertexNormals } from "./geometry.js";
import { upright } from "./upright.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {import("./renderer.js").MeshArrays} MeshArrays */

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
