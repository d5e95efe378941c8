import assert from "node:assert/strict";
import { test } from "node:test";
import { createStateCommands } from "../../src/input/state_commands.js";
import { fakeDispatcher, fakeModel } from "../page.js";

function fake(state = {}) {
  const model = fakeModel({
    mode: "navigate",
    editable: true,
    outlines: true,
    levels: ["base", "final"],
    ...state,
  });
  const { on, send } = fakeDispatcher();
  createStateCommands({ model, on });
  return { model, send };
}

test("what is on or off is turned over and told to Python", () => {
  const { model, send } = fake();
  send({ kind: "toggle", what: "outlines" });
  assert.deepEqual([model.get("outlines"), model.saves], [false, 1]);
  send({ kind: "toggle", what: "help" });
  assert.equal(model.saves, 1);
});

test("one edits only where that can be", () => {
  const { model, send } = fake();
  send({ kind: "toggle", what: "mode" });
  assert.equal(model.get("mode"), "edit");
  const other = fake({ editable: false });
  other.send({ kind: "toggle", what: "mode" });
  assert.equal(other.model.get("mode"), "navigate");
});

test("levels go by number, as far as there are any", () => {
  const { model, send } = fake();
  send({ kind: "level", index: 1 });
  assert.equal(model.get("level"), "final");
  send({ kind: "level", index: 2 });
  assert.equal(model.get("level"), "final");
});

test("Python is told to cancel and to save", () => {
  const { model, send } = fake();
  send({ kind: "cancel" });
  send({ kind: "save" });
  assert.deepEqual(model.sent, [{ kind: "cancel" }, { kind: "save" }]);
});
