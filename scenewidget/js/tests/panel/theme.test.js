import assert from "node:assert/strict";
import { test } from "node:test";
import { showTheme } from "../../src/panel/theme.js";
import { fakeModel, openPage, PageElement } from "../page.js";

const body = openPage();
const page = /** @type {any} */ (globalThis);
/** @type {Array<() => void>} */
const looks = [];
page.MutationObserver = class {
  /** @param {() => void} look */
  constructor(look) {
    looks.push(look);
  }
  observe() {}
  disconnect() {}
};
page.matchMedia = () => ({ matches: false, addEventListener() {}, removeEventListener() {} });
page.requestAnimationFrame = (/** @type {() => void} */ callback) => callback();

test("the theme is the page's unless the model asks for one", () => {
  body.dataset.jpThemeLight = "true";
  const root = /** @type {any} */ (new PageElement("div"));
  const model = fakeModel({ theme: "auto" });
  const seen = /** @type {any} */ ({});
  const view = /** @type {any} */ ({ setLook: (/** @type {object} */ look) => Object.assign(seen, look) });
  showTheme({ model, view, root, signal: new AbortController().signal });
  assert.deepEqual([root.dataset.theme, seen.isDark], ["light", false]);
  body.dataset.jpThemeLight = "false";
  for (const look of looks) look();
  assert.deepEqual([root.dataset.theme, seen.isDark], ["dark", true]);
  model.set("theme", "light");
  assert.deepEqual([root.dataset.theme, seen.isDark], ["light", false]);
});
