import assert from "node:assert/strict";
import { test } from "node:test";
import { createHelpCard } from "../../src/panel/help_card.js";
import { control, openPage } from "../page.js";

openPage();

test("it lists the keys of the mode, and tells when it opens and closes", () => {
  /** @type {boolean[]} */
  const shown = [];
  const help = createHelpCard((isShown) => shown.push(isShown));
  help.update({ editable: true, mode: "navigate" });
  const looking = help.element.textContent ?? "";
  help.update({ editable: true, mode: "edit" });
  const editing = help.element.textContent ?? "";
  assert.doesNotMatch(looking, /brush/);
  assert.match(editing, /brush/);
  help.show(true);
  assert.equal(help.isShown(), true);
  control(help.element, "Close help").click();
  assert.deepEqual([help.isShown(), shown], [false, [true, false]]);
});
