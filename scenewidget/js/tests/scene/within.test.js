import assert from "node:assert/strict";
import { test } from "node:test";
import { facesWithin, isWithin } from "../../src/scene/within.js";

const places = (/** @type {number[][]} */ pairs) => pairs.map(([x, y]) => ({ x, y }));
// eight by eight pixels, as WebGL gives them, the lowest row first; the face of each is its number from above
const bytes = new Uint8Array(4 * 64);
for (let row = 0; row < 8; row++)
  for (let column = 0; column < 8; column++) bytes[4 * ((7 - row) * 8 + column)] = 8 * row + column + 1;
const snapshot = /** @type {any} */ ({ numbers: { width: 8, height: 8, bytes } });

test("pixels whose middle lies within an outline are taken, as a test of each would", () => {
  const size = { width: 80, height: 80 };
  const star = places([
    [5, 5],
    [75, 12],
    [20, 40],
    [70, 77],
    [8, 60],
  ]);
  const expected = [];
  for (let face = 0; face < 64; face++)
    if (isWithin(star, 10 * (face % 8) + 5, 10 * Math.floor(face / 8) + 5)) expected.push(face);
  assert.deepEqual([...facesWithin(snapshot, star, size)], expected);
  assert.ok(expected.length > 15);
});

test("an outline that leaves the picture takes what is in it", () => {
  const all = places([
    [-50, -50],
    [500, -50],
    [500, 500],
    [-50, 500],
  ]);
  assert.equal(facesWithin(snapshot, all, { width: 8, height: 8 }).size, 64);
});
