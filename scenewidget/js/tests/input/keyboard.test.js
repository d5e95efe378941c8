import assert from "node:assert/strict";
import { test } from "node:test";
import { listenToKeys } from "../../src/input/keyboard.js";
import { fakeDispatcher, fakeModel, fire, openPage, PageElement } from "../page.js";

openPage();

function fake(state = {}) {
  const root = new PageElement("div");
  const [button, select] = [new PageElement("button"), new PageElement("select")];
  root.append(button, select);
  const { take, send } = fakeDispatcher();
  /** @type {any[]} */
  const done = [];
  const closing = [() => false, () => done.push("second") > 0, () => done.push("third") > 0];
  const strides = { stop: (/** @type {string} */ way) => done.push(way ?? "all") };
  const aim = { showCross: (/** @type {boolean} */ isShown) => done.push(isShown) };
  const model = fakeModel({ mode: "edit", editable: true, ...state });
  const { signal } = new AbortController();
  listenToKeys(
    /** @type {any} */ ({ model, view: { isInside: false }, root, aim, strides, closing, send, signal }),
  );
  return { root, button, select, take, done };
}

test("a key says what it means, and the host doesn't have it", () => {
  const { root, take, done } = fake();
  assert.deepEqual(fire(root, "keydown", { key: "c" }), { isStopped: true, isPrevented: true });
  assert.deepEqual(take(), [{ kind: "tool", tool: "cut" }]);
  assert.deepEqual(done, [true]);
  assert.deepEqual(fire(root, "keydown", { key: "y" }), { isStopped: false, isPrevented: false });
});

test("controls keep the keys that are theirs", () => {
  const { button, select, take } = fake();
  fire(button, "keydown", { key: "Enter" });
  fire(select, "keydown", { key: "c" });
  assert.deepEqual(take(), []);
  fire(button, "keydown", { key: "c" });
  assert.equal(take().length, 1);
});

test("Escape closes the first thing that is open", () => {
  const { root, done } = fake();
  fire(root, "keydown", { key: "Escape" });
  assert.deepEqual(done, [true, "second"]);
});

test("where nothing can be edited the host keeps the key to save", () => {
  const { root, take } = fake({ editable: false });
  assert.equal(fire(root, "keydown", { key: "s", ctrlKey: true }).isPrevented, false);
  assert.deepEqual(take(), []);
});

test("one stops walking when the key or the focus goes", () => {
  const { root, done } = fake();
  fire(root, "keyup", { key: "w" });
  fire(root, "focusout");
  assert.deepEqual(done, ["forward", "all"]);
});
