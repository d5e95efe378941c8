import assert from "node:assert/strict";
import { test } from "node:test";
import { command, helpSections } from "../../src/input/keys.js";

const plain = { shiftKey: false, ctrlKey: false, metaKey: false, altKey: false };

test("arrows orbit, with Shift they pan", () => {
  assert.equal(command({ ...plain, key: "ArrowLeft" }, "navigate")?.kind, "orbit");
  assert.equal(command({ ...plain, key: "ArrowLeft", shiftKey: true }, "navigate")?.kind, "pan");
});

test("letters work in either case, digits choose levels", () => {
  assert.deepEqual(command({ ...plain, key: "F", shiftKey: true }, "navigate"), {
    kind: "look",
    from: "here",
  });
  assert.deepEqual(command({ ...plain, key: "2" }, "navigate"), { kind: "level", index: 1 });
  assert.equal(command({ ...plain, key: "Escape" }, "navigate")?.kind, "escape");
});

test("Shift makes another command of some letters", () => {
  assert.deepEqual(command({ ...plain, key: "h" }, "edit"), { kind: "part", what: "hide" });
  assert.deepEqual(command({ ...plain, key: "H", shiftKey: true }, "edit"), { kind: "show_all" });
  assert.deepEqual(command({ ...plain, key: "f" }, "navigate"), { kind: "part", what: "frame" });
});

test("what the mouse edits, keys can edit", () => {
  assert.deepEqual(command({ ...plain, key: "Enter" }, "edit"), { kind: "choose" });
  assert.deepEqual(command({ ...plain, key: "s" }, "edit"), { kind: "part", what: "split" });
  assert.deepEqual(command({ ...plain, key: "n" }, "edit"), { kind: "part", what: "name" });
});

test("keys of the host are left alone", () => {
  for (const key of ["Tab", "a", "F5", " "]) assert.equal(command({ ...plain, key }, "edit"), null);
  for (const key of ["Enter", "n", "s"]) assert.equal(command({ ...plain, key }, "navigate"), null);
  assert.equal(command({ ...plain, key: "f", ctrlKey: true }, "edit"), null);
  assert.equal(command({ ...plain, key: "f", altKey: true }, "edit"), null);
  assert.equal(command({ ...plain, key: "z", ctrlKey: true }, "navigate"), null);
});

test("undo and redo belong to the editor", () => {
  assert.equal(command({ ...plain, key: "z", ctrlKey: true }, "edit")?.kind, "undo");
  assert.equal(command({ ...plain, key: "Z", metaKey: true, shiftKey: true }, "edit")?.kind, "redo");
  assert.equal(command({ ...plain, key: "y", ctrlKey: true }, "edit")?.kind, "redo");
});

test("inside a room letters and arrows walk, outside they don't", () => {
  assert.deepEqual(command({ ...plain, key: "w" }, "navigate", true), { kind: "walk", way: "forward" });
  assert.deepEqual(command({ ...plain, key: "S" }, "edit", true), { kind: "walk", way: "back" });
  assert.deepEqual(command({ ...plain, key: "ArrowLeft" }, "edit", true), { kind: "walk", way: "turn_left" });
  assert.equal(command({ ...plain, key: "w" }, "navigate"), null);
  assert.equal(command({ ...plain, key: "PageUp" }, "navigate"), null);
  assert.deepEqual(command({ ...plain, key: "v" }, "edit", true), { kind: "toggle", what: "inside" });
});

test("in edit mode digits above the levels give names", () => {
  assert.deepEqual(command({ ...plain, key: "3" }, "edit"), { kind: "level", index: 2 });
  assert.deepEqual(command({ ...plain, key: "4" }, "edit"), { kind: "quick_name", index: 0 });
  assert.deepEqual(command({ ...plain, key: "0" }, "edit"), { kind: "quick_name", index: 6 });
  assert.equal(command({ ...plain, key: "0" }, "navigate"), null);
});

test("tools have keys, and a brush is finished by one", () => {
  assert.deepEqual(command({ ...plain, key: "c" }, "edit"), { kind: "tool", tool: "cut" });
  assert.deepEqual(command({ ...plain, key: "g" }, "edit"), { kind: "tool", tool: "brush" });
  assert.deepEqual(command({ ...plain, key: "Enter", shiftKey: true }, "edit"), { kind: "finish" });
  assert.equal(command({ ...plain, key: "c", ctrlKey: true }, "edit"), null);
  assert.deepEqual(command({ ...plain, key: "s", ctrlKey: true }, "navigate"), { kind: "save" });
});

test("the help lists every letter that does something, and no other", () => {
  const SUGGEST = "K"; // heard in suggesting.js
  const lettersIn = (/** @type {Array<[string, string]>} */ rows) =>
    rows.flatMap(([keys]) => keys.split(/[,;] /)).filter((key) => /^[A-Z?]$/.test(key) && key !== SUGGEST);
  for (const mode of /** @type {const} */ (["navigate", "edit"])) {
    const sections = helpSections({ editable: true, mode }).filter(({ title }) => !title.includes("room"));
    const rows = sections.flatMap(({ rows }) => rows);
    const working = [..."ABCDEFGHIJKLMNOPQRSTUVWXYZ?"].filter((key) => command({ ...plain, key }, mode));
    assert.deepEqual(lettersIn(rows).sort(), working.sort());
  }
});

test("the help leaves out what can't be done", () => {
  const titles = (/** @type {Parameters<typeof helpSections>[0]} */ state) =>
    helpSections(state).map(({ title }) => title);
  assert.deepEqual(titles({ editable: false, mode: "navigate" }), ["Look", "Show", "Standing in the room"]);
  assert.deepEqual(titles({ editable: true, mode: "edit", hasTouch: true }), [
    ...["By touch", "Edit", "Look", "Show", "Standing in the room"],
  ]);
});
