import assert from "node:assert/strict";
import { test } from "node:test";
import { placeOn } from "../../src/input/place.js";

/** A picture of 200 × 100 pixels, shown at so many times its size. @param {number} x @param {number} y */
const shown = (x, y = x) => ({
  ...{ clientWidth: 200, clientHeight: 100 },
  getBoundingClientRect: () => ({ left: 30, top: 20, width: 200 * x, height: 100 * y }),
});

test("places are those of the picture, however large the page shows it", () => {
  const [left, top] = [30, 20];
  for (const [x, y] of [
    [1, 1],
    [0.6, 0.6],
    [2.5, 2.5],
    [0.5, 1.5],
  ]) {
    const place = placeOn(shown(x, y), { clientX: left + 50 * x, clientY: top + 40 * y });
    assert.ok(Math.abs(place.x - 50) < 1e-9 && Math.abs(place.y - 40) < 1e-9, `${x}, ${y}`);
  }
});

test("a picture that isn't shown has no places to divide by", () => {
  assert.ok(Number.isFinite(placeOn(shown(0), { clientX: 1, clientY: 1 }).x));
});
