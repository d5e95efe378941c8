import assert from "node:assert/strict";
import { test } from "node:test";
import { readArray, viewArray } from "../../src/wire/wire.js";

test("bytes that start anywhere in their buffer are read right", () => {
  const numbers = new Float32Array([1.5, -2, 3.25]);
  for (const offset of [0, 4, 3]) {
    const buffer = new ArrayBuffer(offset + 12 + 5);
    new Uint8Array(buffer).set(new Uint8Array(numbers.buffer), offset);
    const array = viewArray({ dtype: "float32", shape: [3] }, new DataView(buffer, offset, 12));
    assert.deepEqual([...array], [...numbers]);
  }
});

test("all kinds of bytes that hosts deliver mean the same", () => {
  const bytes = new Uint8Array(new Uint32Array([7, 0xffffffff]).buffer);
  const base64 = Buffer.from(bytes).toString("base64");
  for (const kind of [bytes, bytes.buffer, new DataView(bytes.buffer), base64]) {
    assert.deepEqual([...viewArray({ dtype: "uint32", shape: [2, 1] }, kind)], [7, 0xffffffff]);
  }
});

test("a shape that does not fit the bytes is an error that names both", () => {
  assert.throws(() => viewArray({ dtype: "uint16", shape: [3, 2] }, new ArrayBuffer(8)), /12 bytes, got 8/);
  assert.throws(
    () => viewArray(/** @type {any} */ ({ dtype: "int64", shape: [1] }), new ArrayBuffer(8)),
    /int64/,
  );
});

test("an array is there only once header and bytes have both arrived", () => {
  const state = /** @type {Record<string, any>} */ ({ _headers: {}, _x: new DataView(new ArrayBuffer(4)) });
  const model = /** @type {any} */ ({ get: (/** @type {string} */ name) => state[name] });
  assert.equal(readArray(model, "x"), null);
  state._headers = { x: { dtype: "uint32", shape: [2] } };
  assert.equal(readArray(model, "x"), null);
  state._headers = { x: { dtype: "uint32", shape: [1] } };
  assert.deepEqual([...(readArray(model, "x") ?? [])], [0]);
  state._headers = { x: { dtype: "uint32", shape: [0] } };
  state._x = new DataView(new ArrayBuffer(0));
  assert.equal(readArray(model, "x"), null);
});

test("the same bytes give the same array, other bytes another one", () => {
  const state = /** @type {Record<string, any>} */ ({
    _headers: { x: { dtype: "uint32", shape: [1] } },
    _x: new DataView(new ArrayBuffer(4)),
  });
  const model = /** @type {any} */ ({ get: (/** @type {string} */ name) => state[name] });
  const first = readArray(model, "x");
  assert.equal(readArray(model, "x"), first);
  state._headers = { x: { dtype: "float32", shape: [1] } };
  assert.ok(readArray(model, "x") instanceof Float32Array);
  state._x = new DataView(new ArrayBuffer(4));
  assert.notEqual(readArray(model, "x"), first);
});
