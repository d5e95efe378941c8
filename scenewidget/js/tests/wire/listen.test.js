import assert from "node:assert/strict";
import { test } from "node:test";
import { listen } from "../../src/wire/listen.js";
import { fakeModel } from "../page.js";

test("changes that come together are taken together, by group", async () => {
  const model = fakeModel({ a: 1, b: 1, c: 1 });
  const life = new AbortController();
  /** @type {string[][]} */
  const taken = [];
  listen(
    model,
    { first: ["a", "b"], second: ["c"] },
    (groups) => taken.push([...groups].sort()),
    life.signal,
  );
  model.set("a", 2);
  model.set("c", 2);
  model.set("b", 2);
  assert.deepEqual(taken, []);
  await Promise.resolve();
  assert.deepEqual(taken, [["first", "second"]]);
  model.set("b", 3);
  await Promise.resolve();
  assert.deepEqual(taken.at(-1), ["first"]);
  model.set("a", 3);
  life.abort();
  model.set("c", 3);
  await Promise.resolve();
  assert.equal(taken.length, 2);
});
