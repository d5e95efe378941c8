import assert from "node:assert/strict";
import { test } from "node:test";
import { drawLegend } from "../../src/panel/picture_legend.js";

/** Notes what is drawn where, in pixels of the page. */
function fake() {
  /** @type {any[]} */
  const drawn = [];
  const at = { x: 0, y: 0 };
  const context = {
    save() {},
    restore() {},
    scale: (/** @type {number} */ scale) => drawn.push(["scale", scale]),
    translate: (/** @type {number} */ x, /** @type {number} */ y) => Object.assign(at, { x, y }),
    measureText: (/** @type {string} */ text) => ({ width: 6 * text.length }),
    fillRect: (/** @type {number[]} */ ...[x, y, w, h]) => drawn.push(["rect", at.x + x, at.y + y, w, h]),
    fillText: (/** @type {string} */ text, /** @type {number} */ x) => drawn.push(["text", text, at.x + x]),
    createLinearGradient: () => ({ addColorStop: (/** @type {number} */ t) => drawn.push(["stop", t]) }),
  };
  return {
    context: /** @type {any} */ (context),
    drawn,
    of: (/** @type {string} */ kind) => drawn.filter(([k]) => k === kind),
  };
}
const size = { width: 400, height: 300, scale: 2 };

test("a bar has its title and ends, all within the picture", () => {
  const { context, of } = fake();
  drawLegend(
    context,
    { title: "Height", colors: ["red", "lime", "blue"], ends: ["0", "2.5"] },
    size,
    "light",
  );
  assert.deepEqual(
    of("text").map(([, text]) => text),
    ["Height", "0", "2.5"],
  );
  assert.deepEqual(
    of("stop").map(([, t]) => t),
    [0, 0.5, 1],
  );
  for (const [, x, y, w, h] of of("rect")) assert.ok(x >= 0 && y >= 0 && x + w <= 390 && y + h <= 290);
  assert.deepEqual(of("scale"), [["scale", 2]]);
});

test("samples stand in rows of three, each beside its name", () => {
  const { context, of } = fake();
  const samples = /** @type {Array<[string, string]>} */ (["a", "b", "c", "d"].map((name) => ["red", name]));
  drawLegend(context, { title: "Facing", samples }, size, "dark");
  const [, ...swatches] = of("rect");
  assert.equal(swatches.length, 4);
  assert.equal(swatches[0][1], swatches[3][1]);
  assert.ok(swatches[3][2] > swatches[0][2]);
});
