import assert from "node:assert/strict";
import { test } from "node:test";
import { readMesh } from "../../src/scene/mesh.js";
import { nounOf } from "../../src/wire/traits.js";
import { fakeModel } from "../page.js";

function fake(up = [0, 0, 1]) {
  return fakeModel({
    ...{
      _vertices: Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0).buffer,
      _faces: Uint32Array.of(0, 1, 2).buffer,
    },
    _headers: { vertices: { dtype: "float32", shape: [3, 3] }, faces: { dtype: "uint32", shape: [1, 3] } },
    _up: up,
  });
}

test("a mesh is made once for all views of a model, and anew when up changes", () => {
  const model = fake();
  const mesh = readMesh(model);
  assert.equal(readMesh(model), mesh);
  assert.deepEqual([...(mesh?.normals ?? [])].slice(0, 4), [0, 0, 127, 0]);
  assert.equal(mesh?.colors, null);
  model.set("_up", [1, 0, 0]);
  const turned = readMesh(model);
  assert.notEqual(turned, mesh);
  assert.equal(turned?.vertices[5], 1); // what lay along x is up
});

test("without vertices there is none yet", () => {
  const model = fake();
  model.set("_vertices", null);
  assert.equal(readMesh(model), null);
});

test("points of a cloud are its faces, and their normals turn with them", () => {
  const model = fakeModel({
    _vertices: Float32Array.of(0, 0, 0, 1, 0, 0).buffer,
    _areas: Float32Array.of(0.5, 0.25).buffer,
    _normals: Int8Array.of(127, 0, 0, 127, 0, 0, 0, 0).buffer,
    _headers: {
      vertices: { dtype: "float32", shape: [2, 3] },
      areas: { dtype: "float32", shape: [2] },
      normals: { dtype: "int8", shape: [2, 4] },
    },
    _up: [1, 0, 0],
  });
  const cloud = readMesh(model);
  assert.deepEqual([...(cloud?.faces ?? [])], [0, 0, 0, 1, 1, 1]);
  assert.deepEqual([...(cloud?.normals ?? [])], [0, 0, 127, 127, 0, 0, 0, 0]);
  assert.equal(nounOf(model), "point");
  assert.equal(nounOf(fake()), "face");
});
