import assert from "node:assert/strict";
import { test } from "node:test";
import { neighborsOf, reached, survey } from "../../src/scene/surface.js";
import { surveyOf } from "../../src/scene/surveys.js";

/** What a generator gives in the end. @template T @param {Generator<void, T, void>} work @returns {T} */
function finished(work) {
  for (;;) {
    const { done, value } = work.next();
    if (done) return value;
  }
}

/**
 * A sheet of n × n squares, two faces each; heights by column, shaken by noise.
 * @param {number} n
 * @param {(x: number, y: number) => number} height
 */
function sheet(n, height) {
  const [vertices, faces] = [new Float32Array(3 * (n + 1) ** 2), new Uint32Array(6 * n * n)];
  for (let i = 0; i < (n + 1) ** 2; i++) {
    const [x, y] = [i % (n + 1), Math.floor(i / (n + 1))];
    vertices.set([x, y, height(x, y)], 3 * i);
  }
  for (let i = 0; i < n * n; i++) {
    const a = Math.floor(i / n) * (n + 1) + (i % n);
    faces.set([a, a + 1, a + n + 1, a + 1, a + n + 2, a + n + 1], 6 * i);
  }
  return { vertices, faces, colors: /** @type {Uint8Array | null} */ (null) };
}

const everything = () => true;
/** Noise without chance. @param {number} x @param {number} y */
const noise = (x, y) => 0.06 * (((13 * x + 29 * y) % 7) / 7);

test("faces that share a side are neighbours, corners of their own or not", () => {
  const vertices = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, -0, 1, 0);
  assert.deepEqual(
    [...finished(neighborsOf(vertices, Uint32Array.of(0, 1, 2, 3, 4, 5)))],
    [-1, 1, -1, -1, -1, 0],
  );
});

test("three faces on one side have each other in a ring", () => {
  const vertices = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1);
  const faces = Uint32Array.of(0, 1, 2, 0, 1, 3, 0, 1, 4);
  const neighbors = finished(neighborsOf(vertices, faces));
  assert.deepEqual([neighbors[0], neighbors[3], neighbors[6]], [1, 2, 0]);
});

test("a fold inwards isn't crossed, one outwards is, and noise is neither", () => {
  const n = 24;
  const fold = (/** @type {number} */ way) =>
    sheet(n, (x, y) => noise(x, y) + way * 3 * Math.max(0, x - n / 2));
  const count = (/** @type {number} */ way, sticks = true) => {
    const surface = finished(survey(fold(way)));
    return reached(surface, [0], everything, sticks).length;
  };
  const half = n * n;
  assert.ok(Math.abs(count(1) - half) < 0.1 * half, String(count(1)));
  assert.equal(count(-1), 2 * half);
  assert.equal(count(1, false), 2 * half);
});

test("an edge between colours isn't crossed", () => {
  const mesh = sheet(10, () => 0);
  mesh.colors = new Uint8Array(mesh.vertices.length);
  for (let i = 0; i < 11 * 11; i++) if (i % 11 > 5) mesh.colors[3 * i + 1] = 200;
  const found = reached(finished(survey(mesh)), [0], everything, true);
  assert.ok(found.length >= 100 && found.length < 130, String(found.length));
});

test("specks amid what is reached are filled, what doesn't count stays out, walks don't disturb each other", () => {
  const surface = finished(survey(sheet(10, () => 0)));
  for (let side = 0; side < 3; side++) {
    surface.shut[99] |= 1 << side;
    const next = surface.neighbors[3 * 99 + side];
    for (let k = 0; k < 3; k++) if (surface.neighbors[3 * next + k] === 99) surface.shut[next] |= 1 << k;
  }
  assert.equal(reached(surface, [0], everything, true).length, 200);
  const few = reached(surface, [0], (face) => face < 20 || face === 99, true);
  assert.deepEqual(
    few.sort((a, b) => a - b),
    Array.from({ length: 20 }, (_, face) => face),
  );
  assert.deepEqual(
    reached(surface, [150], (face) => face === 3, true),
    [],
  );
});

test("after very many walks, marks of the first are no longer taken for new ones", () => {
  const surface = finished(survey(sheet(10, () => 0)));
  const few = (/** @type {number} */ face) => face < 20;
  for (const last of [0, 0xffff - 3, 0xffff]) {
    surface.last = last;
    assert.equal(reached(surface, [0], few, true).length, 20);
    assert.equal(reached(surface, [0], everything, true).length, 200);
  }
});

test("all views of a mesh share its surface, and who can't wait has it at once", () => {
  const mesh = sheet(4, () => 0);
  surveyOf(mesh).begin();
  assert.equal(surveyOf(mesh).surface(), surveyOf(mesh).surface());
  assert.equal(surveyOf(mesh).surface().shut.length, 32);
});
