import assert from "node:assert/strict";
import { test } from "node:test";
import {
  boundingBall,
  coarse,
  cornersOf,
  drawable,
  gather,
  sample,
  thinned,
  vertexNormals,
} from "../../src/scene/geometry.js";

/** A square of n × n cells at z = 0, normals up. @param {number} n */
function grid(n) {
  const vertices = [];
  const faces = [];
  for (let i = 0; i <= n; i++) for (let j = 0; j <= n; j++) vertices.push(i / n, j / n, 0);
  const at = (/** @type {number} */ i, /** @type {number} */ j) => i * (n + 1) + j;
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      faces.push(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return { vertices: new Float32Array(vertices), faces: new Uint32Array(faces) };
}

test("every face ends in a corner that carries its number, and is still the same triangle", () => {
  const { vertices, faces } = grid(7);
  const isolated = Uint32Array.from([...faces, 0, 0, 0, 5, 5, 9]); // degenerate ones, too
  const { corner, face, index } = drawable(isolated, vertices.length / 3);
  for (let f = 0; f < isolated.length / 3; f++) {
    const corners = [...index.subarray(3 * f, 3 * f + 3)];
    assert.equal(face[corners[2]], f);
    const [a, b, c] = corners.map((i) => corner[i]);
    const turns = [
      [a, b, c],
      [b, c, a],
      [c, a, b],
    ].map(String);
    assert.ok(turns.includes(String([...isolated.subarray(3 * f, 3 * f + 3)])));
  }
  assert.ok(corner.length <= isolated.length / 3 + 8 + 8); // about one corner a face
});

test("faces can keep numbers of their own", () => {
  const { face, index } = drawable(new Uint32Array([0, 1, 2]), 3, new Uint32Array([42]));
  assert.equal(face[index[2]], 42);
});

test("normals of a plane point along its normal", () => {
  const { vertices, faces } = grid(3);
  const normals = vertexNormals(vertices, faces);
  for (let i = 0; i < normals.length; i += 4) assert.deepEqual([...normals.subarray(i, i + 3)], [0, 0, 127]);
});

test("rows are gathered by corner and padded", () => {
  const rows = new Uint8Array([1, 2, 3, 4, 5, 6]);
  assert.deepEqual([...gather(rows, 3, new Uint32Array([1, 0]), 4)], [4, 5, 6, 0, 1, 2, 3, 0]);
});

test("a sample has the corners and the area of its faces", () => {
  const { vertices, faces } = grid(10);
  const all = sample({ vertices, faces }, 1e6);
  let area = 0;
  for (let i = 0; i < all.normals.length; i += 3) area += all.normals[i + 2] / 2;
  assert.ok(Math.abs(area - 1) < 1e-5);
  assert.ok(sample({ vertices, faces }, 20).points.length <= 9 * 20);
});

test("the ball holds all vertices", () => {
  const { middle, radius } = boundingBall(new Float32Array([0, 0, 0, 2, 4, 4]));
  assert.deepEqual([middle, radius], [[1, 2, 2], 3]);
});

test("the coarse stand-in covers the same square with fewer faces of the same numbers", () => {
  const { vertices, faces } = grid(100);
  const work = coarse(vertices, faces, 2000);
  let step = work.next();
  while (!step.done) step = work.next();
  const { faces: kept, numbers } = step.value;
  assert.ok(numbers.length > 200 && numbers.length < 8000, `${numbers.length}`);
  assert.equal(kept.length, 3 * numbers.length);
  assert.ok(numbers.every((number) => number < 20_000));
  const { normals } = sample({ vertices, faces: kept }, 1e6);
  let area = 0;
  for (let i = 0; i < normals.length; i += 3) area += normals[i + 2] / 2;
  assert.ok(Math.abs(area - 1) < 0.1, `${area}`);
});

test("a point of a cloud stands for a triangle of its area in its plane, around it", () => {
  const cloud = {
    vertices: new Float32Array([1, 2, 3, 4, 5, 6]),
    faces: new Uint32Array([0, 0, 0, 1, 1, 1]),
    areas: new Float32Array([0.5, 0.25]),
    normals: new Int8Array([0, 0, 127, 127, -127, 0, 0, 0]),
  };
  const { points, normals } = sample(cloud, 10);
  assert.deepEqual(
    [...normals.subarray(0, 3)].map((x) => Math.round(1e5 * x) / 1e5 + 0),
    [0, 0, 1],
  );
  assert.ok(Math.abs(Math.hypot(...normals.subarray(3, 6)) - 0.5) < 1e-6);
  assert.ok(normals[3] < -0.49, "a side is kept");
  for (let k = 0; k < 3; k++) {
    const middle = (points[k] + points[3 + k] + points[6 + k]) / 3;
    assert.ok(Math.abs(middle - cloud.vertices[k]) < 1e-6);
    assert.ok(cornersOf(cloud, 0).every(Number.isFinite));
  }
});

test("some points are chosen as if by chance, as many as wanted, everywhere", () => {
  const kept = thinned(100_000, 10_000);
  assert.ok(Math.abs(kept.length - 10_000) < 100);
  const columns = new Set(Array.from(kept, (i) => i % 10));
  assert.equal(columns.size, 10, "no column of a scanner is favoured");
  assert.equal(thinned(5, 10).length, 5);
});
