import assert from "node:assert/strict";
import { test } from "node:test";
import { readMesh } from "../../src/scene/mesh.js";
import { awaitMesh } from "../../src/scene/shared_meshes.js";
import { standIn } from "../../src/wire/saved_model.js";

const headers = { vertices: { dtype: "float32", shape: [3, 3] }, faces: { dtype: "uint32", shape: [1, 3] } };
const lender = (/** @type {string} */ token) =>
  standIn({
    _token: token,
    _headers: headers,
    _vertices: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]),
    _faces: new Uint32Array([0, 1, 2]),
  });
const borrower = (/** @type {string} */ token) =>
  standIn({ _token: "b", _mesh_of: token, _headers: headers, _vertices: new Uint8Array(0) });

test("views that know the name of another's mesh draw the same arrays", () => {
  const mesh = readMesh(lender("one"));
  assert.equal(readMesh(borrower("one")), mesh);
  assert.equal(readMesh(borrower("nobody")), null);
  const turned = borrower("one");
  turned.set("_up", [0, 1, 0]);
  assert.equal(readMesh(turned), null); // it stands otherwise there
});

test("a mesh that comes later is heard of, one that doesn't is asked for", (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const life = new AbortController();
  /** @type {object[]} */
  const sent = [];
  let taken = 0;
  for (const name of ["late", "never"]) {
    const model = { ...borrower(name), send: (/** @type {object} */ message) => sent.push(message) };
    awaitMesh(model, () => taken++, life.signal);
  }
  assert.ok(readMesh(lender("late")));
  assert.equal(taken, 1);
  context.mock.timers.tick(5000);
  assert.deepEqual(sent, [{ kind: "need_mesh" }]);
  life.abort();
});
