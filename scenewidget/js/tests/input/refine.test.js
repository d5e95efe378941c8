import assert from "node:assert/strict";
import { test } from "node:test";
import { createRefine } from "../../src/input/refine.js";
import { fakeDispatcher, fakeModel } from "../page.js";

test("what a button would change is asked of Python and shown; pressed, it is an edit", () => {
  const model = fakeModel({ revision: 7 });
  const dispatcher = fakeDispatcher();
  /** @type {any[]} */
  const shown = [];
  const segments = /** @type {any} */ ({
    ...{ pending: { operations: [] }, offcut: null },
    cutOff(/** @type {number[]} */ faces) {
      shown.push(faces);
      segments.offcut = faces.length > 0 ? {} : null;
    },
  });
  const { signal } = new AbortController();
  createRefine(/** @type {any} */ ({ model, segments, signal, ...dispatcher, picked: () => ({ face: 4 }) }));
  dispatcher.handlers.refine_preview({ how: "grow" });
  const [asked] = model.sent;
  assert.deepEqual([asked.kind, asked.edit, asked.revision], ["preview_edit", { kind: "grow", face: 4 }, 7]);
  model.emit("msg:custom", { kind: "edit_preview", request: "another", first: 0 }, [Uint8Array.of(1)]);
  assert.deepEqual(shown, []);
  model.emit("msg:custom", { kind: "edit_preview", request: asked.request, first: 8, reason: "" }, [
    Uint8Array.of(5),
  ]);
  assert.deepEqual(shown, [[8, 10]]);
  dispatcher.handlers.refine_preview({ how: null });
  assert.deepEqual(shown.at(-1), []);
  dispatcher.handlers.refine({ how: "grow" });
  assert.deepEqual(dispatcher.take("edit"), [{ kind: "edit", edit: { kind: "grow", face: 4 } }]);
});
