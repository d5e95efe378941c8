import assert from "node:assert/strict";
import { test } from "node:test";
import { createPanel } from "../../src/panel/panel.js";
import { control, fakeDispatcher, fire, openPage, PageElement } from "../page.js";

openPage();

function fake() {
  const host = new PageElement("div");
  const dispatcher = fakeDispatcher();
  const panel = createPanel(/** @type {any} */ (host), dispatcher);
  const root = /** @type {any} */ (panel.root);
  return { panel, root, ...dispatcher };
}

test("the page keeps what tests and style sheets rely on", () => {
  const { root } = fake();
  assert.equal(root.classList.contains("scenewidget"), true);
  assert.equal(root.querySelectorAll("canvas").length, 1);
  for (const name of [
    "ready",
    "busy",
    "segments",
    "hovered",
    "picked",
    "target",
    "pending",
    "hidden",
    "moving",
  ])
    assert.notEqual(root.dataset[name], undefined, name);
  for (const name of ["Undo", "Redo", "Save", "Level", "Colour by", "Help"]) control(root, name);
});

test("help and section open by wish and close with Escape's turn", () => {
  const { panel, root, send } = fake();
  assert.equal(panel.closeHelp(), false);
  send({ kind: "toggle", what: "help" });
  assert.equal(control(root, "Help").getAttribute("aria-expanded"), "true");
  assert.deepEqual([panel.closeHelp(), panel.closeHelp()], [true, false]);
  send({ kind: "toggle", what: "section" });
  assert.deepEqual(
    [panel.section.isShown(), panel.closeSection(), panel.closeSection()],
    [true, true, false],
  );
});

test("a press on the picture closes the form and takes the focus", () => {
  const { panel, root, send } = fake();
  send({ kind: "ask_name", face: 1, title: "Segment 1", name: "", place: { x: 0, y: 0 } });
  assert.equal(document.activeElement, root.querySelector(".sw-name"));
  fire(panel.canvas, "pointerenter");
  assert.equal(document.activeElement, root.querySelector(".sw-name")); // somebody is typing
  fire(panel.canvas, "pointerdown");
  assert.equal(document.activeElement, root);
  control(root, "Fit").focus();
  fire(panel.canvas, "pointerenter");
  assert.equal(document.activeElement, root);
});

test("what is said is shown", () => {
  const { root, send } = fake();
  send({ kind: "remark", text: "Nothing to cut" });
  send({ kind: "cross", isShown: true });
  send({ kind: "twin", place: { x: 3, y: 4 } });
  assert.equal(root.querySelector(".sw-remark").textContent, "Nothing to cut");
  assert.equal(root.querySelector(".sw-aim").hidden, false);
  assert.equal(root.querySelector(".sw-twin").style.transform, "translate(3px, 4px)");
});

test("a failure takes the place of everything", () => {
  const { panel, root } = fake();
  panel.showFailure("No WebGL");
  assert.equal(root.textContent, "No WebGL");
});
