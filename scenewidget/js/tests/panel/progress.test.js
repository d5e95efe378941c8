import assert from "node:assert/strict";
import { test } from "node:test";
import { createProgress } from "../../src/panel/progress.js";
import { control, fakeDispatcher, openPage } from "../page.js";

openPage();

test("progress is told in percent where it is known", () => {
  const progress = createProgress(fakeDispatcher().send);
  const text = () => /** @type {any} */ (progress.element).querySelector(".sw-stage-name").textContent;
  progress.update({ busy: true, progress: 0.256, status: "Distances" });
  assert.deepEqual([text(), progress.track.getAttribute("aria-valuenow")], ["Distances  26 %", "26"]);
  progress.update({ busy: true, progress: -1, status: "" });
  assert.deepEqual([text(), progress.track.getAttribute("aria-valuenow")], ["Working  ", null]);
  assert.equal(progress.track.classList.contains("sw-swinging"), true);
  progress.update({ busy: false, progress: 0, status: "" });
  assert.deepEqual([progress.track.hidden, progress.element.hidden], [true, true]);
});

test("one cancels once", () => {
  const { send, take } = fakeDispatcher();
  const progress = createProgress(send);
  progress.update({ busy: true, progress: 0, status: "" });
  const cancel = control(progress.element, "Cancel");
  cancel.click();
  cancel.click();
  assert.deepEqual(take(), [{ kind: "cancel" }]);
  progress.update({ busy: false, progress: 0, status: "" });
  assert.equal(cancel.disabled, false);
});
