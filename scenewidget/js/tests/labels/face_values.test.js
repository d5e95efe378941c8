import assert from "node:assert/strict";
import { test } from "node:test";
import { faceValues, RIGHT_COLOR, spread, WRONG_COLOR } from "../../src/labels/face_values.js";
import { standIn } from "../../src/wire/saved_model.js";

test("right and wrong are the two ends of the colour map, unknown is none", () => {
  const errors = new Uint8Array([0, 1, 2]);
  const data = new DataView(errors.buffer);
  const headers = { face_error: { dtype: "uint8", shape: [3] } };
  const model = standIn({ color_by: "errors", _face_error: data, _headers: headers });
  const drawn = faceValues(model);
  assert.ok(drawn);
  assert.deepEqual([...drawn.values], [0, 1, 65535]);
  assert.deepEqual([...drawn.colormap.slice(0, 3)], RIGHT_COLOR);
  assert.deepEqual([...drawn.colormap.slice(765)], WRONG_COLOR);
  assert.equal(spread(errors), spread(errors));
});

test("without values there is nothing to draw", () => {
  assert.equal(faceValues(standIn({ color_by: "errors", _headers: {} })), null);
  assert.equal(faceValues(standIn({ color_by: "values", _headers: {} })), null);
});
