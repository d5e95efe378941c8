import assert from "node:assert/strict";
import { test } from "node:test";
import { createHistory } from "../../src/panel/history.js";
import { fakeDispatcher, fire, openPage } from "../page.js";

const body = openPage();
const STEPS = [
  { n: 1, title: "Merge", time: 10, problem: "" },
  { n: 2, title: "Split", time: 20, problem: "" },
  { n: 3, title: "Name", time: 30, problem: "no such face" },
];

function fake() {
  const { send, take } = fakeDispatcher();
  const left = { n: 0 };
  const history = createHistory(send, () => left.n++);
  body.append(/** @type {any} */ (history.element));
  history.update(true, STEPS, 2);
  const steps = () => /** @type {any} */ (history.element).querySelectorAll(".sw-step");
  return { history, take, left, steps };
}

test("it begins as segmented, marks where one is, and tells what no longer applies", () => {
  const { steps } = fake();
  const [start, , now, next] = steps();
  assert.match(start.textContent, /As segmented/);
  assert.equal(now.getAttribute("aria-current"), "step");
  assert.deepEqual([start.dataset.state, now.dataset.state, next.dataset.state], ["done", "done", "lost"]);
  assert.match(next.textContent, /no such face/);
});

test("a click goes to a step, but not to where one is", () => {
  const { steps, take } = fake();
  steps()[2].click();
  steps()[0].click();
  assert.deepEqual(take(), [{ kind: "go_to", n: 0 }]);
});

test("steps that are too old to list are counted", () => {
  const { history, steps } = fake();
  history.update(true, [{ n: 8, title: "Merge", time: 10, problem: "" }], 8);
  assert.match(steps()[0].textContent, /7 earlier steps/);
});

test("arrows go from step to step, Escape closes", () => {
  const { history, steps, take, left } = fake();
  steps()[1].focus();
  fire(steps()[1], "keydown", { key: "ArrowDown" });
  assert.equal(document.activeElement, steps()[2]);
  fire(steps()[2], "keydown", { key: "Home" });
  assert.equal(document.activeElement, steps()[0]);
  fire(steps()[0], "keydown", { key: "Escape" });
  assert.deepEqual(take(), [{ kind: "set", name: "history_shown", value: false }]);
  assert.equal(left.n, 1);
  history.update(false, STEPS, 2);
  assert.equal(history.isShown, false);
});
