/**
 * What touches what on the surface of a scan, and where it folds inwards or changes its colour.
 *
 * The page's side of `scenewidget.engine.patch`: a brush that is to stop at a crease can't ask Python sixty times a
 * second. Things meet where the surface turns inwards (Hoffman and Richards 1984, Cognition 18). Normals are
 * smoothed over the surface first, or noise would look like creases.
 */

const SWEEPS = 20; // of the normals
const WIDTH = 0.3; // 1 − cosine from which a neighbour hardly counts
const STEPS = 4096; // of the table of weights, for each 1 − cosine
const WEIGHTS = Float32Array.from({ length: 2.01 * STEPS }, (_, i) =>
  Math.exp(-(((i + 0.5) / STEPS / WIDTH) ** 2)),
);
const CREASE = Math.cos((6 * Math.PI) / 180);
const COLOR_STEP = 32; // of 255, between neighbours
const SPECK = 0.02; // of what is reached; smaller pieces left out amid it are noise
const SLICE = 100_000; // faces between two breaths of the page
const NOBODY = -1;
const MOST_MARKS = 0xffff;

/**
 * @typedef {object} Surface
 * @property {Int32Array} neighbors  three a face, across its sides; −1 where the scan ends. Where more than two faces
 *   share a side, each has the next.
 * @property {Uint8Array} shut  a bit a side: a brush doesn't cross it
 * @property {Uint16Array} mark  by face; of whoever is walking over the surface
 * @property {number} last  mark given
 */

/**
 * Look at a mesh; yields now and then, so that the page lives.
 * @param {{ vertices: Float32Array, faces: Uint32Array, colors: Uint8Array | null }} mesh
 * @returns {Generator<void, Surface, void>}
 */
export function* survey({ vertices, faces, colors }) {
  const nFaces = faces.length / 3;
  const neighbors = yield* neighborsOf(vertices, faces);
  const normals = yield* smoothed(vertices, faces, neighbors);
  const shut = new Uint8Array(nFaces);
  for (let f = 0; f < nFaces; f++) {
    for (let side = 0; side < 3; side++) {
      const g = neighbors[3 * f + side];
      if (g === NOBODY) continue;
      const isShut =
        isCrease(normals, vertices, faces, f, g) || (colors !== null && isStep(colors, faces, f, g));
      if (isShut) shut[f] |= 1 << side;
    }
    if (f % SLICE === SLICE - 1) yield;
  }
  return { neighbors, shut, mark: new Uint16Array(nFaces), last: 0 };
}

/**
 * Faces that are reached over the surface, among those that count. Specks that noise leaves amid them are filled.
 * @param {Surface} surface
 * @param {Iterable<number>} seeds  faces that are in; those that don't count are passed over
 * @param {(face: number) => boolean} counts
 * @param {boolean} sticks  whether sides that are shut aren't crossed
 * @returns {number[]}
 */
export function reached(surface, seeds, counts, sticks) {
  const { neighbors, shut, mark } = surface;
  const isIn = newMarks(surface, 3);
  const [isOut, isLeft] = [isIn + 1, isIn + 2]; // isLeft: counts, but isn't reached
  /** @type {number[]} */
  const faces = [];
  const look = (/** @type {number} */ face) => {
    if (mark[face] < isIn) mark[face] = counts(face) ? isLeft : isOut;
    return mark[face];
  };
  for (const seed of seeds)
    if (look(seed) === isLeft) {
      mark[seed] = isIn;
      faces.push(seed);
    }
  /** Faces beyond a shut side. @type {number[]} */
  const beyond = [];
  for (let i = 0; i < faces.length; i++) {
    const face = faces[i];
    for (let side = 0; side < 3; side++) {
      const next = neighbors[3 * face + side];
      if (next === NOBODY || look(next) !== isLeft) continue;
      if (sticks && (shut[face] >> side) & 1) beyond.push(next);
      else {
        mark[next] = isIn;
        faces.push(next);
      }
    }
  }
  const rest = (/** @type {number} */ face) => look(face) === isLeft;
  return [...faces, ...pieces(surface, beyond, rest, isOut, SPECK * faces.length)];
}

/**
 * Small pieces of what is left out of some faces, amid them.
 * @param {Surface} surface
 * @param {Set<number>} faces
 * @param {(face: number) => boolean} counts
 * @returns {number[]}
 */
export function specks(surface, faces, counts) {
  const { neighbors, mark } = surface;
  const isDone = newMarks(surface, 1);
  const beyond = [];
  for (const face of faces) {
    for (let side = 3 * face; side < 3 * face + 3; side++) {
      const next = neighbors[side];
      if (next !== NOBODY && !faces.has(next)) beyond.push(next);
    }
  }
  const rest = (/** @type {number} */ face) => mark[face] !== isDone && !faces.has(face) && counts(face);
  return pieces(surface, beyond, rest, isDone, SPECK * faces.size);
}

/** The first of some marks in a row that no face has. @param {Surface} surface @param {number} n */
function newMarks(surface, n) {
  if (surface.last + n > MOST_MARKS) {
    surface.mark.fill(0);
    surface.last = 0;
  }
  surface.last += n;
  return surface.last - n + 1;
}

/**
 * Faces of the connected pieces that aren't too large.
 * @param {Surface} surface
 * @param {number[]} seeds
 * @param {(face: number) => boolean} isRest  and hasn't got the mark yet
 * @param {number} isDone  the mark that those get that were looked at
 * @param {number} most  faces
 */
function pieces({ neighbors, mark }, seeds, isRest, isDone, most) {
  /** Faces of pieces that are too large to be followed to their ends. @type {Set<number>} */
  const large = new Set();
  const found = [];
  for (const seed of seeds) {
    if (!isRest(seed)) continue;
    const piece = [seed];
    mark[seed] = isDone;
    let isLarge = false;
    for (let i = 0; i < piece.length && piece.length <= most; i++) {
      for (let side = 3 * piece[i]; side < 3 * piece[i] + 3; side++) {
        const next = neighbors[side];
        if (next === NOBODY) continue;
        isLarge ||= large.has(next);
        if (!isRest(next)) continue;
        mark[next] = isDone;
        piece.push(next);
      }
    }
    if (isLarge || piece.length > most) for (const face of piece) large.add(face);
    else found.push(...piece);
  }
  return found;
}

/**
 * The face across each side.
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 * @returns {Generator<void, Int32Array, void>}
 */
export function* neighborsOf(vertices, faces) {
  const nVertices = vertices.length / 3;
  const same = yield* welded(vertices);
  const low = (/** @type {number} */ i) => Math.min(same[faces[i]], same[faces[following(i)]]);
  const high = (/** @type {number} */ i) => Math.max(same[faces[i]], same[faces[following(i)]]);
  // sides in the order of their lower vertex
  const first = new Uint32Array(nVertices + 1);
  for (let i = 0; i < faces.length; i++) first[low(i) + 1]++;
  for (let v = 0; v < nVertices; v++) first[v + 1] += first[v];
  yield;
  const sides = new Uint32Array(faces.length);
  const filled = first.slice(0, nVertices);
  for (let i = 0; i < faces.length; i++) {
    sides[filled[low(i)]++] = i;
    if (i % (3 * SLICE) === 0) yield;
  }
  const neighbors = new Int32Array(faces.length).fill(NOBODY);
  for (let v = 0; v < nVertices; v++) {
    for (let a = first[v]; a < first[v + 1]; a++) {
      const end = high(sides[a]);
      if (end === v || neighbors[sides[a]] !== NOBODY) continue; // a side without length joins nothing
      let last = sides[a];
      for (let b = a + 1; b < first[v + 1]; b++) {
        if (high(sides[b]) !== end) continue;
        neighbors[last] = Math.floor(sides[b] / 3);
        last = sides[b];
      }
      if (last !== sides[a]) neighbors[last] = Math.floor(sides[a] / 3);
    }
    if (v % SLICE === SLICE - 1) yield;
  }
  return neighbors;
}

/** The corner after a corner of the same face. @param {number} i */
function following(i) {
  return i % 3 === 2 ? i - 2 : i + 1;
}

/**
 * Of each vertex, the first that lies at the same place: triangles may carry corners of their own.
 * @param {Float32Array} vertices
 * @returns {Generator<void, Uint32Array, void>}
 */
function* welded(vertices) {
  const n = vertices.length / 3;
  let size = 4;
  while (size < 2 * n) size *= 2;
  const table = new Int32Array(size).fill(NOBODY);
  const plain = vertices.map((value) => value + 0); // −0 is 0
  const bits = new Int32Array(plain.buffer);
  const same = new Uint32Array(n);
  for (let v = 0; v < n; v++) {
    let hash = Math.imul(bits[3 * v], 0x9e3779b1) ^ Math.imul(bits[3 * v + 1], 0x85ebca6b);
    hash = Math.imul(hash ^ (hash >>> 15), 0xc2b2ae35) ^ Math.imul(bits[3 * v + 2], 0x27d4eb2f);
    let slot = (hash ^ (hash >>> 13)) & (size - 1);
    for (; table[slot] !== NOBODY; slot = (slot + 1) & (size - 1)) {
      const w = table[slot];
      if (
        bits[3 * w] === bits[3 * v] &&
        bits[3 * w + 1] === bits[3 * v + 1] &&
        bits[3 * w + 2] === bits[3 * v + 2]
      )
        break;
    }
    if (table[slot] === NOBODY) table[slot] = v;
    same[v] = table[slot];
    if (v % SLICE === SLICE - 1) yield;
  }
  return same;
}

/**
 * Normals averaged over the surface but not across creases, as `preprocess.filter_normals` does.
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 * @param {Int32Array} neighbors
 * @returns {Generator<void, Float32Array, void>}
 */
function* smoothed(vertices, faces, neighbors) {
  const nFaces = faces.length / 3;
  const areas = new Float32Array(nFaces);
  let [here, there] = [new Float32Array(faces.length), new Float32Array(faces.length)];
  for (let f = 0; f < nFaces; f++) {
    const [a, b, c] = [3 * faces[3 * f], 3 * faces[3 * f + 1], 3 * faces[3 * f + 2]];
    const [ax, ay, az] = [vertices[a], vertices[a + 1], vertices[a + 2]];
    const [ux, uy, uz] = [vertices[b] - ax, vertices[b + 1] - ay, vertices[b + 2] - az];
    const [vx, vy, vz] = [vertices[c] - ax, vertices[c + 1] - ay, vertices[c + 2] - az];
    const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    const length = Math.sqrt(x * x + y * y + z * z);
    areas[f] = length / 2;
    const part = length > 0 ? 1 / length : 0;
    here[3 * f] = x * part;
    here[3 * f + 1] = y * part;
    here[3 * f + 2] = z * part;
    if (f % SLICE === SLICE - 1) yield;
  }
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    for (let from = 0; from < nFaces; from += SLICE) {
      sweepOnce(here, there, areas, neighbors, from, Math.min(nFaces, from + SLICE));
      yield;
    }
    [here, there] = [there, here];
  }
  return here;
}

/**
 * One sweep over some of the normals.
 * @param {Float32Array} here
 * @param {Float32Array} there
 * @param {Float32Array} areas
 * @param {Int32Array} neighbors
 * @param {number} from
 * @param {number} to
 */
function sweepOnce(here, there, areas, neighbors, from, to) {
  for (let f = from; f < to; f++) {
    const x = here[3 * f];
    const y = here[3 * f + 1];
    const z = here[3 * f + 2];
    const isBlank = x * x + y * y + z * z === 0;
    let sx = areas[f] * x;
    let sy = areas[f] * y;
    let sz = areas[f] * z;
    for (let side = 3 * f; side < 3 * f + 3; side++) {
      const g = neighbors[side];
      if (g === NOBODY) continue;
      const u = here[3 * g];
      const v = here[3 * g + 1];
      const w = here[3 * g + 2];
      const weight = isBlank ? areas[g] : areas[g] * WEIGHTS[((1 - x * u - y * v - z * w) * STEPS) | 0];
      sx += weight * u;
      sy += weight * v;
      sz += weight * w;
    }
    const length = Math.sqrt(sx * sx + sy * sy + sz * sz);
    const part = length > 0 ? 1 / length : 0;
    there[3 * f] = sx * part;
    there[3 * f + 1] = sy * part;
    there[3 * f + 2] = sz * part;
  }
}

/**
 * Whether the surface turns inwards between two faces.
 * @param {Float32Array} normals
 * @param {Float32Array} vertices
 * @param {Uint32Array} faces
 * @param {number} f
 * @param {number} g
 */
function isCrease(normals, vertices, faces, f, g) {
  let cosine = 0;
  for (let k = 0; k < 3; k++) cosine += normals[3 * f + k] * normals[3 * g + k];
  if (cosine >= CREASE) return false;
  let turn = 0; // thrice, from middle to middle
  for (let k = 0; k < 3; k++) {
    let apart = 0;
    for (let corner = 0; corner < 3; corner++)
      apart += vertices[3 * faces[3 * g + corner] + k] - vertices[3 * faces[3 * f + corner] + k];
    turn += apart * (normals[3 * g + k] - normals[3 * f + k]);
  }
  return turn < 0;
}

/**
 * Whether two faces differ in colour.
 * @param {Uint8Array} colors
 * @param {Uint32Array} faces
 * @param {number} f
 * @param {number} g
 */
function isStep(colors, faces, f, g) {
  for (let channel = 0; channel < 3; channel++) {
    let difference = 0;
    for (let k = 0; k < 3; k++)
      difference += colors[3 * faces[3 * f + k] + channel] - colors[3 * faces[3 * g + k] + channel];
    if (Math.abs(difference) > 3 * COLOR_STEP) return true;
  }
  return false;
}
