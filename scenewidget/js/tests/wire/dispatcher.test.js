import assert from "node:assert/strict";
import { test } from "node:test";
import { createDispatcher } from "../../src/wire/dispatcher.js";

test("all who hear a kind hear it, in the order in which they began, before send returns", () => {
  const { on, send } = createDispatcher();
  /** @type {string[]} */
  const heard = [];
  on({ cut: () => heard.push("first"), merge: () => heard.push("other") });
  on({ cut: (/** @type {any} */ { face }) => heard.push(`second ${face}`) });
  send(/** @type {any} */ ({ kind: "cut", face: 3 }));
  send({ kind: "nobody hears this" });
  assert.deepEqual(heard, ["first", "second 3"]);
});

test("what is said meanwhile is heard at once", () => {
  const { on, send } = createDispatcher();
  /** @type {string[]} */
  const heard = [];
  on({
    outer() {
      send({ kind: "inner" });
      heard.push("outer");
    },
    inner: () => heard.push("inner"),
  });
  send({ kind: "outer" });
  assert.deepEqual(heard, ["inner", "outer"]);
});
