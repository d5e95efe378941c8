import assert from "node:assert/strict";
import { test } from "node:test";
import { createCameraCommands } from "../../src/input/camera_commands.js";
import { WHOLE } from "../../src/scene/section.js";
import { fakeDispatcher, fakeModel } from "../page.js";

function fake() {
  /** @type {any[]} */
  const done = [];
  const view = /** @type {any} */ ({
    isInside: false,
    isCut: false,
    openedAbove: "low",
    size: { width: 80, height: 40 },
  });
  for (const name of ["apply", "lookFrom", "goInside", "walk"])
    view[name] = (/** @type {any} */ first) => done.push([name, first]);
  const model = fakeModel({});
  const { on, send, take } = fakeDispatcher();
  createCameraCommands({ model, view, on, send, signal: new AbortController().signal });
  return { view, model, done, send, take };
}

test("movements go to the camera; without a place, a zoom goes to the middle", () => {
  const { done, send } = fake();
  send({ kind: "pan", dx: 1, dy: 2 });
  send({ kind: "zoom", factor: 2 });
  send({ kind: "zoom", factor: 2, x: 1, y: 1 });
  assert.deepEqual(done[0], ["apply", { kind: "pan", dx: 1, dy: 2 }]);
  assert.deepEqual([done[1][1].x, done[1][1].y, done[2][1].x], [40, 20, 1]);
});

test("one looks from where a person or Python says, and goes inside and back", () => {
  const { model, done, send } = fake();
  send({ kind: "look", from: "above" });
  model.emit("msg:custom", { kind: "look", from: "start" });
  model.emit("msg:custom", { kind: "other" });
  send({ kind: "toggle", what: "inside" });
  assert.deepEqual(done, [
    ["lookFrom", "above"],
    ["lookFrom", "start"],
    ["goInside", true],
  ]);
});

test("the ceiling is cut off, and put back", () => {
  const { view, send, take } = fake();
  send({ kind: "toggle", what: "ceiling" });
  view.isCut = true;
  send({ kind: "toggle", what: "ceiling" });
  send({ kind: "cut_ceiling" });
  assert.deepEqual(
    take("set").map(({ value }) => value),
    ["low", WHOLE, "low"],
  );
});
