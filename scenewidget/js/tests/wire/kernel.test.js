import assert from "node:assert/strict";
import { test } from "node:test";
import { watchKernel } from "../../src/wire/kernel.js";

/** A kernel as JupyterLab has it. */
function fakeKernel(id = "one") {
  /** @type {Set<(sender: unknown, status: string) => void>} */
  const slots = new Set();
  return {
    ...{ id, status: "idle", connectionStatus: "connected", isDisposed: false },
    serverSettings: { baseUrl: "http://server/", token: "secret" },
    statusChanged: {
      connect: (/** @type {any} */ slot) => slots.add(slot),
      disconnect: (/** @type {any} */ slot) => slots.delete(slot),
    },
    tell(/** @type {string} */ status) {
      for (const slot of slots) slot(null, status);
    },
    slots,
  };
}

/** @param {import("node:test").TestContext} t */
function fake(t) {
  t.mock.timers.enable({ apis: ["setInterval", "Date"] });
  const kernel = fakeKernel();
  const manager = { kernel: /** @type {any} */ (kernel) };
  const told = { n: 0 };
  const life = new AbortController();
  const watched = watchKernel(manager, () => told.n++, life.signal);
  return { kernel, manager, told, life, watched, wait: (/** @type {number} */ ms) => t.mock.timers.tick(ms) };
}

test("a kernel that was shut down, or replaced, is gone within a second or so, for ever", (t) => {
  const { kernel, manager, told, watched, wait } = fake(t);
  wait(5000);
  assert.equal(watched.state(), "there");
  manager.kernel = null;
  wait(1500);
  assert.deepEqual([watched.state(), told.n], ["gone", 1]);
  manager.kernel = kernel;
  wait(5000);
  assert.deepEqual([watched.state(), told.n], ["gone", 1]);
});

test("another kernel isn't the one that the view is of", (t) => {
  const { manager, watched, wait } = fake(t);
  manager.kernel = fakeKernel();
  wait(1500);
  assert.equal(watched.state(), "there"); // the same by another line
  manager.kernel = fakeKernel("two");
  wait(1500);
  assert.equal(watched.state(), "gone");
});

for (const status of ["restarting", "autorestarting", "dead"]) {
  test(`a kernel that is ${status} has forgotten the view, however short that takes`, (t) => {
    const { kernel, watched } = fake(t);
    kernel.tell("busy");
    assert.equal(watched.state(), "there");
    kernel.tell(status);
    kernel.tell("idle");
    assert.equal(watched.state(), "gone");
  });
}

test("a line that is cut is told of after a while, and when it is back", (t) => {
  t.mock.method(globalThis, "fetch", async () => ({ status: 200 }));
  const { kernel, told, watched, wait } = fake(t);
  kernel.connectionStatus = "connecting";
  wait(1000);
  assert.equal(watched.state(), "there");
  wait(3000);
  assert.deepEqual([watched.state(), told.n], ["cut off", 1]);
  kernel.connectionStatus = "connected";
  wait(1000);
  assert.deepEqual([watched.state(), told.n], ["there", 2]);
});

test("while it is cut the server is asked, and a kernel that it doesn't know is gone", async (t) => {
  /** @type {any[]} */
  const asked = [];
  t.mock.method(globalThis, "fetch", async (/** @type {any[]} */ ...args) => {
    asked.push(args);
    return { status: 404 };
  });
  const { kernel, watched, wait } = fake(t);
  kernel.connectionStatus = "connecting";
  wait(1000);
  await new Promise(setImmediate);
  assert.equal(watched.state(), "gone");
  assert.deepEqual(asked, [
    ["http://server/api/kernels/one", { headers: { Authorization: "token secret" } }],
  ]);
});

test("where there is no manager, nothing is known, and afterwards nothing is left", (t) => {
  const { kernel, life } = fake(t);
  assert.equal(kernel.slots.size, 1);
  life.abort();
  assert.equal(kernel.slots.size, 0);
  const none = watchKernel(undefined, () => assert.fail(), new AbortController().signal);
  assert.equal(none.state(), "there");
});
