import assert from "node:assert/strict";
import { test } from "node:test";
import { createLinkedViews } from "../../src/input/linked_views.js";
import { fakeDispatcher, fakeModel } from "../page.js";

/** @type {any} */ (globalThis).window = new EventTarget();

function fake(group = "pair") {
  const dispatcher = fakeDispatcher();
  /** @type {any[]} */
  const followed = [];
  const view = /** @type {any} */ ({
    follow: (/** @type {any} */ camera) => followed.push(camera),
    placeOf: (/** @type {number[]} */ [x]) => ({ x, y: 0 }),
  });
  const model = fakeModel({ camera_group: group });
  createLinkedViews({ model, view, ...dispatcher, signal: new AbortController().signal });
  return { followed, ...dispatcher };
}

test("one view looks as the other does, without an echo, and strangers don't", () => {
  const [first, second, stranger] = [fake(), fake(), fake("other")];
  first.send({ kind: "moved", camera: "there" });
  assert.deepEqual([first.followed, second.followed, stranger.followed], [[], ["there"], []]);
});

test("what one points at shows in the other, until it points at nothing", () => {
  const [first, second] = [fake(), fake()];
  first.send({ kind: "pointed", face: null, at: null });
  assert.deepEqual(second.take(), []);
  first.send({ kind: "pointed", face: 7, at: [3, 0, 0] });
  assert.deepEqual(second.take(), [
    { kind: "twin", place: { x: 3, y: 0 } },
    { kind: "twin_pointed", face: 7 },
  ]);
  first.send({ kind: "pointed", face: null, at: null });
  assert.deepEqual(second.take()[0], { kind: "twin", place: null });
});
