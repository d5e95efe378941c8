import assert from "node:assert/strict";
import { test } from "node:test";
import { createKeptLooks } from "../../src/scene/kept_looks.js";
import { fakeDispatcher, fakeModel } from "../page.js";

function fake() {
  const start = { yaw: 0 };
  const view = /** @type {any} */ ({
    ...{ start, camera: start, hidden: null },
    partition: { faceAtom: Uint32Array.of(0, 0, 1), atomSegment: Uint32Array.of(4, 5) },
    hide: (/** @type {(atom: number) => boolean} */ isHidden) => {
      view.hidden = Uint8Array.of(Number(isHidden(0)), Number(isHidden(1)));
    },
  });
  const model = fakeModel({ _camera: null, _hidden: [2] });
  const { said, send } = fakeDispatcher();
  return { view, said, looks: createKeptLooks({ model, view, send }) };
}

test("what was hidden last is hidden first; after that, what is hidden is remembered", () => {
  const { view, said, looks } = fake();
  looks.keepHidden();
  assert.deepEqual([...view.hidden], [0, 1]);
  assert.equal(said.length, 0);
  looks.keepHidden();
  assert.equal(said.length, 0);
  view.hidden = Uint8Array.of(1, 0);
  looks.keepHidden();
  assert.deepEqual(said, [{ kind: "set", name: "_hidden", value: [0] }]);
});

test("the camera is remembered once it has been moved", () => {
  const { view, said, looks } = fake();
  looks.keepCamera();
  assert.equal(said.length, 0);
  view.camera = { yaw: 1 };
  looks.keepCamera();
  assert.deepEqual(said, [{ kind: "set", name: "_camera", value: { yaw: 1 } }]);
});
