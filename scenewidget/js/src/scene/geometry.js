/**
 * From vertices and faces as sent to arrays as drawn.
 *
 * WebGL2 has no number of the triangle in its fragment shader. A `flat` value is taken from a triangle's
 * last corner, so every face gets a corner of its own that carries its number: about as many corners as
 * faces, a third of what drawing each face with three corners of its own would need.
 */

/** @typedef {{ corner: Uint32Array, face: Uint32Array, index: Uint32Array }} Drawable */
/** @typedef {import("./camera.js").Ball} Ball */
/**
 * Of a cloud, with areas and normals of its points in rows of four; face i is point i.
 * @typedef {{ vertices: Float32Array, faces: Uint32Array, areas?: Float32Array | null, normals?: Int8Array }} Surface
 */

/**
 * Corners and index of triangles that know their own number.
 * @param {Uint32Array} faces  three vertices a face
 * @param {number} nVertices
 * @param {Uint32Array} [numbers]  number of each face; its position by default
 * @returns {Drawable}  corner: its vertex; face: number of the face that ends in it; index: three corners a face
 */
export function drawable(faces, nVertices, numbers) {
  const nFaces = faces.length / 3;
  const cornerOf = new Int32Array(nVertices).fill(-1);
  const corner = new Uint32Array(nVertices + nFaces);
  const face = new Uint32Array(nVertices + nFaces);
  const isOwned = new Uint8Array(nVertices + nFaces);
  const index = new Uint32Array(faces.length);
  let n = 0;
  for (let i = 0; i < faces.length; i++) {
    const vertex = faces[i];
    if (cornerOf[vertex] < 0) {
      cornerOf[vertex] = n;
      corner[n++] = vertex;
    }
    index[i] = cornerOf[vertex];
  }
  for (let f = 0; f < nFaces; f++) {
    const [a, b, c] = [index[3 * f], index[3 * f + 1], index[3 * f + 2]];
    let own = !isOwned[c] ? c : !isOwned[a] ? a : !isOwned[b] ? b : -1;
    if (own === a && own !== c) index.set([b, c, a], 3 * f);
    else if (own === b && own !== c) index.set([c, a, b], 3 * f);
    if (own < 0) {
      own = n++;
      corner[own] = corner[c];
      index[3 * f + 2] = own;
    }
    isOwned[own] = 1;
    face[own] = numbers ? numbers[f] : f;
  }
  return { corner: corner.slice(0, n), face: face.slice(0, n), index };
}

/**
 * Unit normals at the vertices, mean of the faces around weighted by area, as signed bytes in rows of four.
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 * @returns {Int8Array}
 */
export function vertexNormals(vertices, faces) {
  const sums = new Float32Array(vertices.length);
  for (let i = 0; i < faces.length; i += 3) {
    const [a, b, c] = [3 * faces[i], 3 * faces[i + 1], 3 * faces[i + 2]];
    const ux = vertices[b] - vertices[a];
    const uy = vertices[b + 1] - vertices[a + 1];
    const uz = vertices[b + 2] - vertices[a + 2];
    const vx = vertices[c] - vertices[a];
    const vy = vertices[c + 1] - vertices[a + 1];
    const vz = vertices[c + 2] - vertices[a + 2];
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    sums[a] += x;
    sums[a + 1] += y;
    sums[a + 2] += z;
    sums[b] += x;
    sums[b + 1] += y;
    sums[b + 2] += z;
    sums[c] += x;
    sums[c + 1] += y;
    sums[c + 2] += z;
  }
  const normals = new Int8Array((vertices.length / 3) * 4);
  for (let v = 0, n = 0; v < sums.length; v += 3, n += 4) {
    const length = Math.sqrt(sums[v] ** 2 + sums[v + 1] ** 2 + sums[v + 2] ** 2) || 1;
    normals[n] = Math.round((127 * sums[v]) / length);
    normals[n + 1] = Math.round((127 * sums[v + 1]) / length);
    normals[n + 2] = Math.round((127 * sums[v + 2]) / length);
  }
  return normals;
}

/**
 * Rows of an array picked by corner.
 * @template {Float32Array | Int8Array | Uint8Array} T
 * @param {T} rows
 * @param {number} width  items a row
 * @param {Uint32Array} corner
 * @param {number} [padded]  items a row of the result
 * @returns {T}
 */
export function gather(rows, width, corner, padded = width) {
  const Kind = /** @type {any} */ (rows.constructor);
  const result = new Kind(corner.length * padded);
  for (let i = 0; i < corner.length; i++) {
    const from = corner[i] * width;
    const to = i * padded;
    for (let k = 0; k < width; k++) result[to + k] = rows[from + k];
  }
  return result;
}

/**
 * Corners of a face; of a cloud those of a triangle as large as what its point stands for, in its plane.
 * @param {Surface} surface
 * @param {number} face
 * @returns {number[]}  x, y, z of one corner after the other
 */
export function cornersOf({ vertices, faces, areas = null, normals }, face) {
  if (!areas || !normals) {
    const corner = (/** @type {number} */ k) => 3 * faces[3 * face + k];
    return [0, 1, 2].flatMap((k) => [...vertices.subarray(corner(k), corner(k) + 3)]);
  }
  const [x, y, z] = vertices.subarray(3 * face, 3 * face + 3);
  const length = Math.hypot(normals[4 * face], normals[4 * face + 1], normals[4 * face + 2]) || 1;
  const [a, b, c] = [0, 1, 2].map((k) => normals[4 * face + k] / length);
  const across = Math.abs(a) < 0.6 ? [0, c, -b] : [-c, 0, a]; // at right angles to the normal
  const size = Math.sqrt((4 * areas[face]) / (3 * Math.sqrt(3))) / (Math.hypot(...across) || 1);
  const [ux, uy, uz] = across.map((value) => value * size);
  const [vx, vy, vz] = [b * uz - c * uy, c * ux - a * uz, a * uy - b * ux];
  return [0, 1, 2].flatMap((k) => {
    const [p, q] = [Math.cos((2 * Math.PI * k) / 3), Math.sin((2 * Math.PI * k) / 3)];
    return [x + p * ux + q * vx, y + p * uy + q * vy, z + p * uz + q * vz];
  });
}

/**
 * Some faces, evenly spread over the list: their corners, and their normals as long as their area.
 * @param {Surface} surface
 * @param {number} [most]
 * @param {ArrayLike<number>} [among]  faces; all by default
 */
export function sample(surface, most = 30_000, among) {
  const nFaces = among ? among.length : surface.faces.length / 3;
  const step = Math.max(1, nFaces / most);
  const n = Math.ceil(nFaces / step);
  const points = new Float32Array(9 * n);
  const normals = new Float32Array(3 * n);
  for (let k = 0; k < n; k++) {
    const f = Math.min(nFaces - 1, Math.floor(k * step));
    points.set(cornersOf(surface, among ? among[f] : f), 9 * k);
    const p = points.subarray(9 * k, 9 * k + 9);
    const [ux, uy, uz] = [p[3] - p[0], p[4] - p[1], p[5] - p[2]];
    const [vx, vy, vz] = [p[6] - p[0], p[7] - p[1], p[8] - p[2]];
    normals.set([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], 3 * k);
  }
  return { points, normals };
}

/**
 * A ball around the box of the points.
 * @param {Float32Array} vertices
 * @returns {Ball}
 */
export function boundingBall(vertices) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < vertices.length; i += 3) {
    for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k], vertices[i + k]);
      high[k] = Math.max(high[k], vertices[i + k]);
    }
  }
  const extent = low.map((value, k) => high[k] - value);
  return {
    middle: [low[0] + extent[0] / 2, low[1] + extent[1] / 2, low[2] + extent[2] / 2],
    radius: Math.max(Math.hypot(...extent) / 2, 1e-6),
  };
}

/**
 * A coarse stand-in for a large mesh, drawn while the camera moves: vertices are gathered in the cells of a
 * grid, faces that lie in three cells stay and keep their numbers. Yields now and then, so that the page lives.
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 * @param {number} nWanted  faces, roughly
 * @returns {Generator<void, { faces: Uint32Array, numbers: Uint32Array }, void>}
 */
export function* coarse(vertices, faces, nWanted) {
  const nFaces = faces.length / 3;
  const { normals } = sample({ vertices, faces }, 20_000);
  let area = 0;
  for (let i = 0; i < normals.length; i += 3)
    area += Math.hypot(normals[i], normals[i + 1], normals[i + 2]) / 2;
  area *= nFaces / (normals.length / 3);
  const { middle, radius } = boundingBall(vertices);
  yield;
  const size = Math.max(Math.sqrt((2 * area) / nWanted), (2 * radius) / 400);
  const n = Math.ceil((2 * radius) / size) + 1;
  const cellVertex = new Int32Array(n ** 3).fill(-1);
  const stand = new Uint32Array(vertices.length / 3);
  yield;
  for (let v = 0; v < stand.length; v++) {
    const x = Math.floor((vertices[3 * v] - middle[0] + radius) / size);
    const y = Math.floor((vertices[3 * v + 1] - middle[1] + radius) / size);
    const z = Math.floor((vertices[3 * v + 2] - middle[2] + radius) / size);
    const cell = x + n * (y + n * z);
    if (cellVertex[cell] < 0) cellVertex[cell] = v;
    stand[v] = cellVertex[cell];
    if ((v & 0x3ffff) === 0x3ffff) yield;
  }
  const kept = [];
  for (let f = 0; f < nFaces; f++) {
    const [a, b, c] = [stand[faces[3 * f]], stand[faces[3 * f + 1]], stand[faces[3 * f + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(f);
    if ((f & 0x3ffff) === 0x3ffff) yield;
  }
  const numbers = Uint32Array.from(kept);
  const result = new Uint32Array(3 * numbers.length);
  for (let i = 0; i < numbers.length; i++) {
    for (let k = 0; k < 3; k++) result[3 * i + k] = stand[faces[3 * numbers[i] + k]];
  }
  return { faces: result, numbers };
}

/**
 * Some of many points, by a number that looks like chance: lines of a scanner leave no pattern.
 * @param {number} n
 * @param {number} nWanted  roughly
 * @returns {Uint32Array}  ascending
 */
export function thinned(n, nWanted) {
  const limit = (2 ** 32 * nWanted) / Math.max(1, n);
  const kept = [];
  for (let i = 0; i < n; i++) if (Math.imul(i + 1, 0x9e3779b1) >>> 0 < limit) kept.push(i);
  return Uint32Array.from(kept);
}
