import assert from "node:assert/strict";
import { test } from "node:test";
import { joined, nowhere, scissor, widen } from "../../src/scene/area.js";

test("an area holds what it was widened by, and all of the picture takes any in", () => {
  const area = nowhere();
  widen(area, { x: 10, y: 20 });
  widen(area, { x: 30, y: 5 });
  assert.deepEqual(area, { left: 10, top: 5, right: 30, bottom: 20 });
  const other = { left: 0, top: 8, right: 12, bottom: 40 };
  assert.deepEqual(joined(area, other), { left: 0, top: 5, right: 30, bottom: 40 });
  assert.equal(joined(area, null), null);
});

test("WebGL counts pixels from below, and cuts nothing outside the picture", () => {
  const size = { width: 200, height: 100 };
  assert.deepEqual(scissor({ left: 10, top: 20, right: 30, bottom: 40 }, 2, size), [12, 12, 56, 56]);
  assert.deepEqual(scissor({ left: -9, top: -9, right: 999, bottom: 999 }, 2, size), [0, 0, 200, 100]);
  assert.deepEqual(scissor(nowhere(), 1, size).slice(2), [0, 0]);
});
