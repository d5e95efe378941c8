import assert from "node:assert/strict";
import { test } from "node:test";
import { Pending, pendingOf } from "../../src/labels/pending.js";

const undo = /** @type {const} */ ({ kind: "undo" });
const redo = /** @type {const} */ ({ kind: "redo" });

test("operations wait until Python has answered them", () => {
  const pending = new Pending("me");
  assert.deepEqual(pending.add(undo), { client: "me", number: 1 });
  assert.deepEqual(pending.add(redo), { client: "me", number: 2 });
  pending.answered({ other: 9 });
  assert.deepEqual(pending.operations, [undo, redo]);
  pending.answered({ other: 9, me: 1 });
  assert.deepEqual(pending.operations, [redo]);
  pending.answered(undefined);
  assert.deepEqual(pending.operations, [redo]);
});

test("views of one model share what is on its way, and are told of it", () => {
  const pending = pendingOf("model 1");
  assert.equal(pendingOf("model 1"), pending);
  assert.notEqual(pendingOf(""), pendingOf(""));
  let told = 0;
  pending.watchers.add(() => told++);
  pending.add(undo);
  assert.equal(told, 1);
  pending.forget();
  assert.deepEqual([told, pending.operations, pending.age], [2, [], 0]);
  assert.deepEqual(pending.add(redo).number, 2); // an old answer can't be taken for a new one
});
