import assert from "node:assert/strict";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { savedModel, standIn } from "../../src/wire/saved_model.js";
import { readArray } from "../../src/wire/wire.js";

test("a stand-in tells of changes until it is asked to stop", () => {
  const model = standIn({ level: "final" });
  let told = 0;
  const callback = () => told++;
  model.on("change:level", callback);
  model.set("level", "base");
  model.set("level", "base");
  model.set("other", 1);
  assert.deepEqual([model.get("level"), told], ["base", 1]);
  model.off("change:level", callback);
  model.set("level", "final");
  assert.equal(told, 1);
});

test("arrays of a saved page are those that were saved", async () => {
  const faces = new Uint32Array([0, 1, 2, 70_000, 4, 5]);
  const data = gzipSync(new Uint8Array(faces.buffer)).toString("base64");
  const arrays = { faces: { dtype: "uint32", shape: [2, 3], data } };
  const model = await savedModel({ state: { height: 300 }, arrays });
  assert.deepEqual(readArray(model, "faces"), faces);
  assert.equal(model.get("height"), 300);
});
