import assert from "node:assert/strict";
import { test } from "node:test";
import { changes, createAnnouncer } from "../../src/panel/announcer.js";
import { openPage } from "../page.js";

openPage();

/** @type {import("../../src/panel/announcer.js").Told} */
const rest = { busy: false, mode: "edit", nSegments: 9, nHidden: 0, undo: null, redo: null, pending: 0 };

test("edits are told with what they leave, undone ones as such", () => {
  const merged = { ...rest, undo: "Merge", nSegments: 8 };
  assert.equal(changes(rest, merged), "Merge. 8 segments");
  assert.equal(changes(merged, { ...rest, redo: "Merge" }), "Undone: Merge. 9 segments");
  assert.equal(changes({ ...rest, redo: "Merge" }, merged), "Merge. 8 segments");
  assert.equal(changes(rest, rest), "");
});

test("so are the mode, a computation and what is hidden", () => {
  assert.equal(changes(rest, { ...rest, mode: "navigate" }), "Looking");
  assert.equal(changes(rest, { ...rest, busy: true }), "Computing");
  assert.equal(changes({ ...rest, busy: true }, { ...rest, nSegments: 1 }), "Done: 1 segment");
  assert.equal(changes(rest, { ...rest, nHidden: 2 }), "2 segments hidden");
  assert.equal(changes({ ...rest, nHidden: 2 }, rest), "Everything shown");
});

test("nothing is told of the first state, nor before Python has answered", () => {
  const announcer = createAnnouncer();
  announcer.update(rest);
  assert.equal(announcer.element.textContent, "");
  announcer.update({ ...rest, undo: "Merge", nSegments: 8, pending: 1 });
  assert.equal(announcer.element.textContent, "");
  announcer.update({ ...rest, undo: "Merge the chair", nSegments: 8 });
  assert.equal(announcer.element.textContent, "Merge the chair. 8 segments");
});
