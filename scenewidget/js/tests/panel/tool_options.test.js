import assert from "node:assert/strict";
import { test } from "node:test";
import { FIRST_OPTIONS } from "../../src/input/tool_options.js";
import { createToolOptionsBar } from "../../src/panel/tool_options.js";
import { control, fire, openPage } from "../page.js";

openPage();

test("the bar shows the options of the tool in hand, and sends what is changed", () => {
  /** @type {any[]} */
  const changes = [];
  const bar = createToolOptionsBar(
    (/** @type {any} */ wish) => changes.push(wish.changes),
    () => {},
  );
  assert.equal(bar.element.hidden, true);
  bar.showTool("paint");
  assert.equal(bar.element.hidden, false);
  control(bar.element, "Take away").click();
  control(bar.element, "Stick to surface").click();
  const radius = control(bar.element, "Brush radius");
  radius.value = "7,5";
  fire(radius, "change");
  radius.value = "large";
  fire(radius, "change");
  assert.equal(radius.value, "12");
  assert.deepEqual(changes, [{ takesAway: true }, { sticks: false }, { radius: { px: 7.5, cm: 4 } }]);
  bar.show({ ...FIRST_OPTIONS, takesAway: true, unit: "cm" });
  assert.equal(control(bar.element, "Take away").getAttribute("aria-pressed"), "true");
  assert.equal(radius.value, "4");
  bar.showTool("merge");
  assert.equal(bar.element.hidden, true);
});
