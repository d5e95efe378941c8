import assert from "node:assert/strict";
import { test } from "node:test";
import { createToolOptions, FIRST_OPTIONS, resized } from "../../src/input/tool_options.js";
import { fakeDispatcher } from "../page.js";

test("an option that is set is told to all, the others stay", () => {
  const { send, on, handlers, take } = fakeDispatcher();
  const options = createToolOptions({ send, on });
  handlers.option({ changes: { unit: "cm" } });
  assert.deepEqual(options.current, { ...FIRST_OPTIONS, unit: "cm" });
  assert.deepEqual(take("options"), [{ kind: "options", options: options.current }]);
  options.resize("paint", -1);
  assert.deepEqual(options.current.radius, { px: 12, cm: 3.2 });
  options.resize("slice", 1);
  assert.equal(options.current.offset, 2);
  handlers.option({ changes: { plane: "wall" } });
  options.resize("slice", 1);
  assert.equal(options.current.offset, 2.5);
});

test("every step changes the radius, in round numbers and within bounds", () => {
  assert.deepEqual(resized({ unit: "px", radius: { px: 2, cm: 1 } }, 1.25), { px: 3, cm: 1 });
  assert.deepEqual(resized({ unit: "px", radius: { px: 2, cm: 1 } }, 0.8), { px: 2, cm: 1 });
  assert.deepEqual(resized({ unit: "cm", radius: { px: 2, cm: 190 } }, 1.25), { px: 2, cm: 200 });
  assert.deepEqual(resized({ unit: "cm", radius: { px: 2, cm: 12 } }, 1.25), { px: 2, cm: 15 });
});
