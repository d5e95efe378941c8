import assert from "node:assert/strict";
import { test } from "node:test";
import { createLegend, legendOf } from "../../src/panel/legend.js";
import { fakeModel, openPage } from "../page.js";

openPage();

test("values have a bar with their ends", () => {
  const colormap = Uint8Array.from({ length: 768 }, (_, i) => i % 256);
  const model = fakeModel({
    ...{ color_by: "values", values_legend: { title: "Height", low: 0.12345, high: 2 } },
    ...{ _colormap: colormap.buffer, _headers: { colormap: { dtype: "uint8", shape: [256, 3] } } },
  });
  const legend = legendOf(model);
  assert.deepEqual([legend?.title, legend?.ends], ["Height", ["0.123", "2"]]);
  assert.equal(legend?.colors?.[0], "rgb(0 1 2)");
});

test("normals are told by the mesh's own axes, and what faces the other way", () => {
  const names = legendOf(fakeModel({ color_by: "normals", _up: [0, 0, 1] }))?.samples?.map(
    ([, name]) => name,
  );
  assert.deepEqual(names, ["+x", "+y", "up", "−x", "−y", "down"]);
});

test("errors are the same or different; segments need no legend", () => {
  const legend = legendOf(fakeModel({ color_by: "errors", errors_title: "Truth" }));
  assert.deepEqual(
    legend?.samples?.map(([, name]) => name),
    ["same", "different"],
  );
  assert.equal(legendOf(fakeModel({ color_by: "segments" })), null);
  assert.match(legendOf(fakeModel({ color_by: "confidence" }))?.ends?.[0] ?? "", /unsure/);
});

test("it shows a bar or samples, or nothing", () => {
  const legend = createLegend();
  legend.show({ title: "Errors", samples: [["red", "different"]] });
  const bar = /** @type {any} */ (legend.element).querySelector(".sw-legend-bar");
  assert.deepEqual([legend.element.hidden, bar.hidden], [false, true]);
  legend.show({ title: "Height", colors: ["red", "blue"], ends: ["0", "1"] });
  assert.equal(bar.hidden, false);
  legend.show(null);
  assert.equal(legend.element.hidden, true);
});
