import assert from "node:assert/strict";
import { test } from "node:test";
import { hashedColor, oklch, packColor } from "../../src/labels/palette.js";

test("Oklch without chroma is grey, its ends are black and white", () => {
  assert.deepEqual(oklch(0, 0, 1), [0, 0, 0]);
  assert.deepEqual(oklch(1, 0, 1), [255, 255, 255]);
  const [red, green, blue] = oklch(0.6, 0, 2);
  assert.ok(red === green && green === blue);
});

test("sRGB red is at its place in Oklch", () => {
  assert.deepEqual(oklch(0.62796, 0.25768, (29.234 * Math.PI) / 180), [255, 0, 0]);
});

test("a part keeps its colour, and neighbouring numbers differ clearly", () => {
  assert.equal(hashedColor(17), hashedColor(17));
  for (let i = 0; i < 2000; i++) {
    const [a, b] = [hashedColor(i), hashedColor(i + 1)];
    const apart = [0, 8, 16].reduce(
      (sum, shift) => sum + Math.abs(((a >> shift) & 255) - ((b >> shift) & 255)),
      0,
    );
    assert.ok(apart > 40, `${i}: ${apart}`);
  }
});

test("a colour is packed with red lowest", () => {
  assert.equal(packColor(1, 2, 3), 0x030201);
});
