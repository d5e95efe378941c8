import assert from "node:assert/strict";
import { test } from "node:test";
import { createErrorBar } from "../../src/panel/error_bar.js";
import { control, fakeDispatcher, openPage } from "../page.js";

openPage();

test("an error stays until it is dismissed", () => {
  const { send, take } = fakeDispatcher();
  const bar = createErrorBar(send);
  bar.update({ error: "No faces" });
  assert.deepEqual([bar.element.hidden, bar.element.textContent], [false, "No facesDismiss"]);
  control(bar.element, "Dismiss").click();
  assert.deepEqual(take(), [{ kind: "set", name: "error", value: "" }]);
  bar.update({ error: "" });
  assert.equal(bar.element.hidden, true);
});
