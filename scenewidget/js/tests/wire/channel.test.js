import assert from "node:assert/strict";
import { test } from "node:test";
import { hear, post } from "../../src/wire/channel.js";

/** @type {any} */ (globalThis).window = new EventTarget();

test("those on a channel hear what is posted there, until they have had enough", () => {
  const life = new AbortController();
  /** @type {any[]} */
  const heard = [];
  hear(
    () => "room",
    (message) => heard.push(message),
    life.signal,
  );
  post("room", { n: 1 });
  post("hall", { n: 2 });
  post("", { n: 3 });
  life.abort();
  post("room", { n: 4 });
  assert.deepEqual(heard, [{ n: 1 }]);
});

test("the channel may change, and none is heard by nobody", () => {
  let channel = "";
  /** @type {any[]} */
  const heard = [];
  hear(
    () => channel,
    (message) => heard.push(message),
    new AbortController().signal,
  );
  post("", { n: 1 });
  channel = "room";
  post("room", { n: 2 });
  assert.deepEqual(heard, [{ n: 2 }]);
});
