import assert from "node:assert/strict";
import { test } from "node:test";
import controls from "../../src/controls/index.js";
import { control, fakeModel, fire, openPage, PageElement } from "../page.js";

openPage();
const page = /** @type {any} */ (globalThis);
Object.assign(page, {
  matchMedia: () => ({ matches: false, addEventListener() {}, removeEventListener() {} }),
});
page.MutationObserver = class {
  observe() {}
  disconnect() {}
};
page.document.body.dataset.jpThemeLight = "true";

function fake(mark = "") {
  const field = { name: "n", label: "Segments", tip: "", group: "", kind: "slider", low: 0, high: 9 };
  const more = { name: "seed", label: "Seed", tip: "", group: "Repeat", kind: "number" };
  const model = fakeModel({
    ...{
      fields: [field, more],
      values: { n: 3, seed: 0 },
      idle: {},
      problems: {},
      changed: ["seed"],
      family: [],
    },
    ...{
      preset: "best",
      presets: ["best"],
      code: "",
      can_rerun: false,
      can_suggest: false,
      scores: [],
      revision: 1,
    },
    _channel: "",
  });
  const el = new PageElement("div");
  el.classList.add(mark);
  const stop = controls.render({ model, el: /** @type {any} */ (el) });
  return { model, el, stop };
}

test("settings are sent when they are set, shown when Python has taken them, counted where they are folded", async () => {
  const { model, el } = fake();
  assert.match(el.textContent, /1 changed/);
  const exact = control(el, "Segments, exactly");
  exact.value = "5";
  fire(exact, "input");
  fire(exact, "change");
  assert.deepEqual(model.sent, [{ kind: "set", name: "n", value: 5 }]);
  model.set("values", { n: 6, seed: 0 });
  await Promise.resolve();
  assert.equal(exact.value, "6");
});

test("a movement asks for a preview, not more often than it can be drawn", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { model, el } = fake();
  const [track] = el.querySelectorAll("input");
  for (const value of ["4", "5", "6"]) {
    /** @type {any} */ (track).value = value;
    fire(track, "input");
  }
  t.mock.timers.tick(200);
  assert.deepEqual(model.sent, [{ kind: "move", name: "n", value: 6 }]);
});

test("without a kernel settings are disabled and say why", () => {
  const { el } = fake("jupyter-widgets-disconnected");
  const [all] = /** @type {any} */ (el.querySelectorAll("fieldset"));
  assert.deepEqual([all.disabled, el.querySelector(".swc")?.dataset.live], [true, "false"]);
  assert.match(el.textContent, /The kernel is gone/);
  const live = fake();
  assert.equal(/** @type {any} */ (live.el.querySelector("fieldset")).disabled, false);
});

test("stopped, it leaves nothing behind", () => {
  const { el, stop } = fake();
  stop();
  assert.equal(el.children.length, 0);
});
