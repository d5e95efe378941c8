import assert from "node:assert/strict";
import { test } from "node:test";
import { createToolbox } from "../../src/panel/toolbox.js";
import { control, openPage } from "../page.js";

openPage();

test("a tool is taken by its button, the one in hand isn't taken again", () => {
  /** @type {string[]} */
  const taken = [];
  const toolbox = createToolbox((tool) => taken.push(tool));
  control(toolbox.element, "Merge").click();
  control(toolbox.element, "Cut").click();
  toolbox.show("cut");
  control(toolbox.element, "Cut").click();
  control(toolbox.element, "Merge").click();
  assert.deepEqual(taken, ["cut", "merge"]);
  assert.equal(control(toolbox.element, "Cut").getAttribute("aria-pressed"), "true");
});
