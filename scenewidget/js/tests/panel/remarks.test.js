import assert from "node:assert/strict";
import { test } from "node:test";
import { relayRemarks } from "../../src/panel/remarks.js";
import { fakeDispatcher, fakeModel } from "../page.js";

test("what Python says at rest is a remark, what it says of a computation isn't", () => {
  const model = fakeModel({ busy: false, status: "" });
  const { send, take } = fakeDispatcher();
  const life = new AbortController();
  relayRemarks({ model, send, signal: life.signal });
  model.set("status", "Nothing to undo");
  assert.deepEqual(take(), [{ kind: "remark", text: "Nothing to undo" }]);
  model.set("busy", true);
  assert.deepEqual(take(), [{ kind: "remark", text: "" }]);
  model.set("status", "Distances");
  model.set("busy", false);
  assert.deepEqual(take(), []);
  life.abort();
  model.set("status", "late");
  assert.deepEqual(take(), []);
});
