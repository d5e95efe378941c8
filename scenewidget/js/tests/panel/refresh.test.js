import assert from "node:assert/strict";
import { test } from "node:test";
import { createRefresh } from "../../src/panel/refresh.js";
import { fakeDispatcher, fakeModel } from "../page.js";

/** A model with nothing to draw, and all that follows it as notes of what it was given. */
function fake(state = {}) {
  /** @type {any[]} */
  const given = [];
  const note = (/** @type {string} */ what) => (/** @type {any} */ value) => given.push([what, value]);
  const model = fakeModel({
    ...{ color_by: "segments", values_legend: {}, notices: [], mode: "edit", editable: true, height: 420 },
    ...{ section: "whole", ...state },
  });
  const segments = /** @type {any} */ ({
    ...{ isPreview: false, undo: null, redo: null, count: 7, read: note("read") },
    pending: { age: 0, operations: [], watchers: new Set() },
  });
  const view = { setLook: note("look"), setSection: note("section"), setMesh: note("mesh"), partition: null };
  const panel = { update: note("panel"), showPreview() {}, listSegments() {} };
  const hand = { tool: "merge", letGo: note("let go"), renew: note("renew") };
  const looks = { keepHidden: note("keep hidden"), keepCamera: note("keep camera") };
  const live = { isLive: true, isCut: false, isAside: false };
  const root = /** @type {any} */ ({ style: {}, dataset: {} });
  const dispatcher = fakeDispatcher();
  const life = new AbortController();
  const takeAll = createRefresh(
    /** @type {any} */ ({
      ...{ model, view, segments, root, panel, hand, looks, measure() {}, signal: life.signal },
      ...{
        connection: { isLive: () => live.isLive, isCutOff: () => live.isCut },
        context: { isAside: () => live.isAside },
        ...dispatcher,
      },
    }),
  );
  const take = (/** @type {string} */ what) => given.splice(0).filter(([name]) => name === what);
  return { model, segments, root, live, take, takeAll, life, send: dispatcher.send };
}

test("the root says how many segments there are, and in which mode one is", () => {
  const { root, take, takeAll } = fake();
  takeAll();
  assert.deepEqual(
    [root.style.height, root.dataset.segments, root.dataset.mode, root.dataset.live],
    ["420px", "7", "edit", "true"],
  );
  takeAll();
  assert.equal(take("let go").length, 1); // once a mode
});

test("what is hidden isn't remembered while something else is shown for the moment", () => {
  const { segments, take, send } = fake();
  send({ kind: "segments" });
  send({ kind: "hidden" });
  assert.equal(take("keep hidden").length, 2);
  segments.isPreview = true;
  send({ kind: "segments" });
  send({ kind: "hidden" });
  assert.equal(take("keep hidden").length, 0);
});

test("without a kernel one looks, and one bar says why", () => {
  const { model, segments, live, take, send } = fake();
  live.isLive = false;
  send({ kind: "state" });
  const [[, state]] = take("panel");
  assert.deepEqual(
    [model.get("mode"), state.notices.map((/** @type {any} */ { key }) => key)],
    ["navigate", ["gone"]],
  );
  live.isCut = true;
  send({ kind: "state" });
  assert.equal(take("panel")[0][1].notices[0].key, "cut");
  segments.pending.operations.push({});
  live.isAside = true;
  send({ kind: "state" });
  assert.deepEqual(
    take("panel")[0][1].notices.map((/** @type {any} */ { key }) => key),
    ["aside", "lost"],
  );
});

test("edits that nobody answers are told of when their time has come", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { segments, take, send, life } = fake();
  segments.pending.operations.push({});
  send({ kind: "state" });
  assert.deepEqual(take("panel")[0][1].notices, []);
  segments.pending.age = 9000;
  t.mock.timers.tick(9000);
  assert.deepEqual(
    take("panel")[0][1].notices.map((/** @type {any} */ { key }) => key),
    ["lost"],
  );
  life.abort();
  assert.equal(segments.pending.watchers.size, 0);
});

test("a change of the model is taken, with what belongs to it", async () => {
  const { model, take } = fake();
  model.set("level", "base");
  await Promise.resolve();
  assert.equal(take("renew").length, 1);
  model.set("outlines", false);
  await Promise.resolve();
  const given = take("renew");
  assert.equal(given.length, 0);
});
