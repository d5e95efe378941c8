import assert from "node:assert/strict";
import { test } from "node:test";
import { createRubberBand } from "../../src/panel/rubber_band.js";
import { openPage } from "../page.js";

openPage();

test("a line goes from end to end; without a tip its beginning alone is marked", () => {
  const band = createRubberBand();
  const svg = /** @type {any} */ (band.element);
  assert.equal(svg.style.display, "none");
  band.show({ x: 1, y: 2 }, { x: 3, y: 4 }, true);
  const line = svg.querySelector("line");
  assert.deepEqual(
    ["x1", "y1", "x2", "y2"].map((name) => line.getAttribute(name)),
    ["1", "2", "3", "4"],
  );
  assert.deepEqual([svg.style.display, svg.classList.contains("sw-rubber-held")], ["", true]);
  band.show({ x: 1, y: 2 }, null, false);
  assert.deepEqual([line.style.display, svg.classList.contains("sw-rubber-held")], ["none", false]);
  band.show(null, null, false);
  assert.equal(svg.style.display, "none");
});
