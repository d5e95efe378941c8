import assert from "node:assert/strict";
import { test } from "node:test";
import { watchContext } from "../../src/scene/context_watch.js";
import { fakeDispatcher, fire, openPage, PageElement } from "../page.js";

openPage();
/** @type {(entries: Array<{ isIntersecting: boolean }>) => void} */
let seen = () => {};
/** @type {any} */ (globalThis).IntersectionObserver = class {
  /** @param {typeof seen} callback */
  constructor(callback) {
    seen = callback;
  }
  observe() {}
  disconnect() {}
};

function fake() {
  const canvas = new PageElement("canvas");
  const { take, send } = fakeDispatcher();
  const made = { again: 0 };
  const { signal } = new AbortController();
  const context = watchContext(/** @type {any} */ (canvas), { send, again: () => made.again++ }, signal);
  return { canvas, take, made, context };
}

test("a context that comes back by itself is told of, and no more", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { canvas, take, made, context } = fake();
  fire(canvas, "webglcontextlost");
  fire(canvas, "webglcontextrestored");
  t.mock.timers.tick(10_000);
  assert.deepEqual(take(), [{ kind: "lost" }, { kind: "restored" }]);
  assert.deepEqual([made.again, context.isAside()], [0, false]);
});

test("one that stays away puts the picture aside until it is scrolled into sight", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { canvas, take, made, context } = fake();
  seen([{ isIntersecting: false }]);
  fire(canvas, "webglcontextlost");
  t.mock.timers.tick(10_000);
  assert.deepEqual(take(), [{ kind: "lost" }, { kind: "state" }]);
  assert.deepEqual([made.again, context.isAside()], [0, true]);
  seen([{ isIntersecting: true }]);
  assert.equal(made.again, 1);
});
