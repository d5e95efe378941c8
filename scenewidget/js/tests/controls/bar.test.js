import assert from "node:assert/strict";
import { test } from "node:test";
import { createBar } from "../../src/controls/bar.js";
import { control, openPage } from "../page.js";

openPage();
const state = /** @type {any} */ ({
  ...{ preset: "best", presets: ["best", "thesis"], nChanged: 1, code: "sw.Params()" },
  ...{ canRerun: false, canSuggest: true, scores: [] },
});

function fake(changes = {}) {
  /** @type {any[]} */
  const sent = [];
  const bar = createBar({ send: (message) => sent.push(message), suggest: (what) => sent.push(what) });
  bar.update({ ...state, ...changes });
  return { bar, sent };
}

test("its buttons go back to the preset, suggest and compute again", () => {
  const { bar, sent } = fake();
  control(bar.element, "Reset to preset").click();
  control(bar.element, "Next suggestion").click();
  control(bar.element, "Name what shapes tell").click();
  control(bar.element, "Segment again").click();
  assert.deepEqual(sent, [{ kind: "preset", name: "best" }, "next", "names", { kind: "rerun" }]);
});

test("what makes no sense now isn't offered", () => {
  const { bar } = fake({ nChanged: 0, canSuggest: false });
  assert.equal(control(bar.element, "Reset to preset").disabled, true);
  assert.equal(control(bar.element, "Next suggestion").hidden, true);
  assert.equal(control(bar.element, "Name what shapes tell").hidden, true);
  assert.equal(control(bar.element, "Segment again").hidden, true);
  assert.equal(bar.scores.hidden, true);
});

test("scores say whether they have become better", () => {
  const scores = [{ name: "RI", text: "0.95", tip: "Rand index", trend: "better" }];
  const { bar } = fake({ scores });
  assert.equal(bar.scores.hidden, false);
  assert.match(bar.scores.textContent ?? "", /RI0\.95▲/);
});
