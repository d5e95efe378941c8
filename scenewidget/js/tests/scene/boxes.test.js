import assert from "node:assert/strict";
import { test } from "node:test";
import { cornersOfBox, pathOfBox, sizesOfBox } from "../../src/scene/boxes.js";

const boxes = new Float32Array([
  ...[1, 2, 3],
  ...[2, 0, 0],
  ...[0, 1, 0],
  ...[0, 0, 0.5],
  ...Array(12).fill(NaN),
]);

test("a box has eight corners around its middle, and its sizes", () => {
  const corners = cornersOfBox(boxes, 0, (point) => point) ?? [];
  assert.deepEqual(corners[0], [-1, 1, 2.5]);
  assert.deepEqual(corners[7], [3, 3, 3.5]);
  assert.deepEqual(sizesOfBox(boxes, 0), [4, 2, 1]);
});

test("a segment without a box, or that Python doesn't know yet, has none", () => {
  assert.equal(
    cornersOfBox(boxes, 1, (point) => point),
    null,
  );
  assert.equal(
    cornersOfBox(boxes, 9, (point) => point),
    null,
  );
});

test("twelve edges are drawn, those that reach behind the eye aren't", () => {
  const places = Array.from({ length: 8 }, (_, i) => ({ x: i, y: 2 * i }));
  assert.equal(pathOfBox(places).split("M").length - 1, 12);
  assert.equal(pathOfBox([null, ...places.slice(1)]).split("M").length - 1, 9);
});
