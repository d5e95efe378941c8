import assert from "node:assert/strict";
import { test } from "node:test";
import { createStatusLine } from "../../src/panel/status_line.js";
import { openPage } from "../page.js";

openPage();

const rest = { summary: "5 faces", status: "Done", busy: false, pending: 0 };

function fake() {
  const line = createStatusLine();
  line.update(rest);
  const text = (/** @type {string} */ name) =>
    /** @type {HTMLElement} */ (/** @type {any} */ (line.element).querySelector(`.sw-${name}`));
  return { line, text };
}

test("what is pointed at takes the place of what there is", () => {
  const { line, text } = fake();
  assert.equal(text("status-text").textContent, "5 faces  ·  Done");
  line.hover({ text: "Segment 1", color: "red" });
  assert.deepEqual([text("status-text").textContent, text("swatch").hidden], ["Segment 1", false]);
  line.hover(null);
  assert.equal(text("swatch").hidden, true);
});

test("a remark shows for a while, in the place of the status", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { line, text } = fake();
  line.remark("Nothing to cut");
  assert.deepEqual(
    [text("remark").textContent, text("status-text").textContent],
    ["Nothing to cut", "5 faces"],
  );
  t.mock.timers.tick(6000);
  assert.deepEqual([text("remark").textContent, text("status-text").textContent], ["", "5 faces  ·  Done"]);
});

test("edits count as pending when their answer takes long", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { line, text } = fake();
  line.update({ ...rest, pending: 2 });
  assert.equal(text("pending").hidden, true);
  t.mock.timers.tick(400);
  assert.deepEqual([text("pending").hidden, text("pending").textContent], [false, "2 edits pending"]);
  line.update(rest);
  assert.equal(text("pending").hidden, true);
});

test("while it computes, the status is told elsewhere", () => {
  const { line, text } = fake();
  line.update({ ...rest, busy: true });
  assert.equal(text("status-text").textContent, "5 faces");
});
