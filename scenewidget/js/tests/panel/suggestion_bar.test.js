import assert from "node:assert/strict";
import { test } from "node:test";
import { createSuggestionBar } from "../../src/panel/suggestion_bar.js";
import { control, fakeDispatcher, fakeModel, fire, openPage, PageElement } from "../page.js";

openPage();
/** @type {any} */ (globalThis).window = new EventTarget();

const SUGGESTION = {
  number: 7,
  kind: "merge",
  title: "Merge both",
  face: 3,
  faces: [3, 5],
  onto_face: 9,
  level: "final",
};

function fake() {
  const dispatcher = fakeDispatcher();
  const [root, dock] = [new PageElement("div"), new PageElement("div")];
  root.append(dock);
  const model = fakeModel({ editable: true, level: "base", suggestion: {}, _channel: "one" });
  /** @type {number[]} */
  const looked = [];
  const segments = { isPreview: false, suggested: [] };
  const around = /** @type {any} */ ({ model, root, ...dispatcher, segments });
  const live = { isLive: true };
  around.connection = { isLive: () => live.isLive };
  Object.assign(around, { view: { lookAround: (/** @type {number} */ face) => looked.push(face) } });
  createSuggestionBar({ ...around, signal: new AbortController().signal }, /** @type {any} */ (dock));
  return {
    model,
    root,
    segments,
    dock,
    looked,
    live,
    ...dispatcher,
    bar: /** @type {any} */ (dock.children[0]),
  };
}

test("a suggestion is shown at its level, lit and looked at", async () => {
  const { model, root, segments, looked, take, bar } = fake();
  assert.equal(bar.hidden, true);
  model.set("suggestion", SUGGESTION);
  await Promise.resolve();
  assert.deepEqual(segments.suggested, [3, 5]);
  assert.deepEqual([bar.hidden, root.dataset.suggestion, looked], [false, "merge", [3]]);
  assert.deepEqual(take("set", "suggested", "segments").slice(-3), [
    { kind: "segments" },
    { kind: "suggested", edit: { face: 3, onto: 9 } },
    { kind: "set", name: "level", value: "final" },
  ]);
});

test("K asks for one, Enter accepts, K skips, Escape ends; one answer at a time", () => {
  const { model, root } = fake();
  fire(root, "keydown", { key: "k" });
  fire(root, "keydown", { key: "k" });
  assert.deepEqual(model.sent, [{ kind: "suggest", do: "next", number: 0 }]);
  for (const [key, meant] of [
    ["Enter", "accept"],
    ["k", "skip"],
    ["Escape", "close"],
  ]) {
    model.set("suggestion", SUGGESTION);
    assert.equal(fire(root, "keydown", { key }).isPrevented, true);
    assert.deepEqual(model.sent.at(-1), { kind: "suggest", do: meant, number: 7 });
  }
});

test("its buttons do the same", () => {
  const { model, dock } = fake();
  model.set("suggestion", SUGGESTION);
  control(dock, "Skip").click();
  assert.deepEqual(model.sent, [{ kind: "suggest", do: "skip", number: 7 }]);
});

test("without a kernel there is nothing to judge", () => {
  const { model, root, live, bar, send } = fake();
  model.set("suggestion", SUGGESTION);
  live.isLive = false;
  send({ kind: "state" });
  assert.equal(bar.hidden, true);
  fire(root, "keydown", { key: "k" });
  assert.deepEqual(model.sent, []);
});
