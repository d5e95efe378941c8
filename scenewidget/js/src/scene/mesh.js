/** The scan as a model holds it, as arrays to draw. */

import { readArray } from "../wire/wire.js";
import { boundingBall, vertexNormals } from "./geometry.js";
import { borrowed, lend } from "./shared_meshes.js";
import { upright, uprightAxes, uprightNormals } from "./upright.js";

/** @typedef {import("../wire/wire.js").Model} Model */
/** @typedef {import("./shared_meshes.js").UprightMesh} UprightMesh */

/** Arrays as drawn, shared by all views of a model. @type {WeakMap<Model, UprightMesh>} */
const meshes = new WeakMap();

/**
 * @param {Model} model
 * @returns {UprightMesh | null}
 */
export function readMesh(model) {
  const known = meshes.get(model);
  const up = model.get("_up") ?? [0, 0, 1];
  if (known?.up === String(up)) return known;
  const given = /** @type {Float32Array | null} */ (readArray(model, "vertices"));
  const colors = /** @type {Uint8Array | null} */ (readArray(model, "vertex_colors"));
  const areas = /** @type {Float32Array | null} */ (readArray(model, "areas"));
  const sides = /** @type {Int8Array | null} */ (readArray(model, "normals"));
  if (!given) return remembered(model, borrowed(model));
  const faces = areas ? pointsAsFaces(areas.length) : readArray(model, "faces");
  if (!faces || (areas && !sides)) return null;
  const vertices = upright(given, up);
  const mesh = {
    vertices,
    faces: /** @type {Uint32Array} */ (faces),
    colors,
    areas,
    normals: sides ? uprightNormals(sides, up) : vertexNormals(vertices, /** @type {Uint32Array} */ (faces)),
    bounds: boundingBall(vertices),
    axes: vertices === given ? null : uprightAxes(up),
    up: String(up),
  };
  lend(model, mesh);
  return remembered(model, mesh);
}

/** @param {Model} model @param {UprightMesh | null} mesh */
function remembered(model, mesh) {
  if (mesh) meshes.set(model, mesh);
  return mesh;
}

/** Of a cloud, face i is point i. @param {number} n */
function pointsAsFaces(n) {
  const faces = new Uint32Array(3 * n);
  for (let i = 0; i < faces.length; i++) faces[i] = Math.floor(i / 3);
  return faces;
}
