import assert from "node:assert/strict";
import { test } from "node:test";
import { createOutline, pathOf } from "../../src/panel/outline.js";
import { openPage } from "../page.js";

openPage();

test("a line runs from corner to corner, and back where it is closed", () => {
  const places = [
    { x: 1, y: 2 },
    { x: 3.1429, y: 4 },
    { x: 0, y: 9 },
  ];
  assert.equal(pathOf(places, true), "M1 2L3.1 4L0 9Z");
  assert.equal(pathOf(places.slice(0, 2), true), "M1 2L3.1 4");
  assert.equal(pathOf([], true), "");
});

test("words stand above the middle; without places nothing shows", () => {
  const outline = createOutline();
  const { element } = outline;
  outline.show({
    places: [
      { x: 0, y: 10 },
      { x: 20, y: 30 },
    ],
    isClosed: false,
    hasDots: true,
    label: "2 m",
  });
  const label = element.querySelector(".sw-outline-label");
  assert.deepEqual(
    [label?.textContent, label?.getAttribute("x"), label?.getAttribute("y")],
    ["2 m", "10", "12"],
  );
  assert.equal(element.style.display, "");
  outline.show({ places: [], isClosed: false, hasDots: true, label: "" });
  assert.equal(element.style.display, "none");
});
