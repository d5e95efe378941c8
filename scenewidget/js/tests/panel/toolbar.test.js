import assert from "node:assert/strict";
import { test } from "node:test";
import { colorings, createToolbar } from "../../src/panel/toolbar.js";
import { control, fakeDispatcher, openPage } from "../page.js";

openPage();

const state = /** @type {any} */ ({
  ...{ colorBy: "segments", hasPartition: true, hasConfidence: false, hasValues: false, hasScan: true },
  ...{ levels: ["base", "final"], level: "final", mixing: 1, outlines: true, backFaces: false },
  ...{
    section: [
      [0, 1],
      [0, 1],
      [0, 1],
    ],
    segmentList: false,
    editable: true,
    mode: "navigate",
  },
  ...{ undo: "Merge", redo: null, nHidden: 0, historyShown: false, errorsTitle: "", valuesTitle: "" },
});

function fake(changes = {}) {
  const { send, take } = fakeDispatcher();
  const [button, word] = [document.createElement("i"), document.createElement("i")];
  const toolbar = createToolbar(send, { button: /** @type {any} */ (button), word });
  toolbar.update({ ...state, ...changes });
  return { toolbar, take, press: (/** @type {string} */ name) => control(toolbar.element, name) };
}

test("only colourings that there is something for are offered", () => {
  assert.deepEqual(
    colorings(state).map(([value]) => value),
    ["segments", "parts", "normals", "scan", "shaded"],
  );
  const more = { ...state, levels: [], hasValues: true, valuesTitle: "Height", errorsTitle: "Truth" };
  assert.deepEqual(colorings(more).slice(0, 3), [
    ["segments", "Segments"],
    ["errors", "Errors"],
    ["values", "Height"],
  ]);
});

test("buttons say what they want, as on or off as the model is", () => {
  const { take, press } = fake();
  press("Outlines").click();
  press("Back faces").click();
  press("Edit").click();
  press("Top view").click();
  press("Help").click();
  press("Cut").click();
  assert.deepEqual(take(), [
    { kind: "set", name: "outlines", value: false },
    { kind: "set", name: "back_faces", value: true },
    { kind: "set", name: "mode", value: "edit" },
    { kind: "look", from: "above" },
    { kind: "toggle", what: "help" },
    { kind: "tool", tool: "cut" },
  ]);
});

test("undo tells its step, redo that there is none", () => {
  const { press } = fake();
  assert.deepEqual([press("Undo").disabled, press("Undo").title], [false, "Undo: Merge (Ctrl + Z)"]);
  assert.deepEqual([press("Redo").disabled, press("Redo").title], [true, "Nothing to redo"]);
});

test("a section, a place inside and an open history show as pressed", () => {
  const { toolbar, press } = fake({
    section: [
      [0, 0.5],
      [0, 1],
      [0, 1],
    ],
    historyShown: true,
  });
  toolbar.showInside(true);
  for (const name of ["Section", "First-person view", "History"])
    assert.equal(press(name).getAttribute("aria-pressed"), "true", name);
});

test("where nothing can be edited there are no tools for it", () => {
  const { press } = fake({ editable: false, historyShown: true });
  assert.equal(press("Edit").parentElement.hidden, true);
  assert.equal(press("Cut").parentElement.hidden, true);
  assert.equal(press("History").getAttribute("aria-pressed"), "false");
});

test("seldom used buttons wait behind one that says whether it is open", () => {
  const { toolbar, press } = fake();
  const isOpen = () => [
    press("More").getAttribute("aria-expanded"),
    toolbar.element.classList.contains("sw-open"),
  ];
  assert.deepEqual(isOpen(), ["false", false]);
  press("More").click();
  assert.deepEqual(isOpen(), ["true", true]);
  press("More").click();
  assert.deepEqual(isOpen(), ["false", false]);
});

test("a column of the table of segments is a colour of its own", () => {
  const { toolbar, take, press } = fake({
    columns: ["area"],
    column: "area",
    colorBy: "values",
    hasValues: true,
  });
  const select = /** @type {any} */ (press("Colour by"));
  assert.equal(select.value, "column:area");
  assert.ok(
    !colorings({ ...state, columns: ["area"], column: "area", hasValues: true }).some(
      ([name]) => name === "values",
    ),
  );
  select.onchange();
  select.value = "segments";
  select.onchange();
  assert.deepEqual(take(), [
    { kind: "set", name: "column", value: "area" },
    { kind: "set", name: "color_by", value: "segments" },
  ]);
  assert.ok(toolbar);
});
