import assert from "node:assert/strict";
import { test } from "node:test";
import { watchConnection } from "../../src/wire/connection.js";
import { fakeModel, openPage, PageElement } from "../page.js";

openPage();
/** @type {Array<() => void>} */
const observers = [];
/** @type {any} */ (globalThis).MutationObserver = class {
  /** @param {() => void} callback */
  constructor(callback) {
    observers.push(callback);
  }
  observe() {}
  disconnect() {}
};

test("Jupyter's mark on an element around tells that the kernel has gone, once", () => {
  const [cell, host] = [new PageElement("div"), new PageElement("div")];
  cell.append(host);
  let changes = 0;
  const { signal } = new AbortController();
  const connection = watchConnection(fakeModel({}), /** @type {any} */ (host), () => changes++, signal);
  assert.equal(connection.isLive(), true);
  cell.classList.add("jupyter-widgets-disconnected");
  for (const look of [...observers, ...observers]) look();
  assert.deepEqual([connection.isLive(), changes], [false, 1]);
});
