import assert from "node:assert/strict";
import { test } from "node:test";
import { lostEdits } from "../../src/panel/notices.js";

const edits = [{}, {}];

test("edits are lost when nobody has answered for long, or the kernel is gone", () => {
  assert.deepEqual(lostEdits({ age: 0, operations: [] }, false), { notices: [], wait: null });
  assert.deepEqual(lostEdits({ age: 3000, operations: edits }, true), { notices: [], wait: 5000 });
  const late = lostEdits({ age: 9000, operations: edits }, true);
  assert.match(late.notices[0].text, /^No answer from the kernel to 2 edits yet/);
  assert.deepEqual(late.notices[0].actions, [["Take them back", "forget"]]);
  const gone = lostEdits({ age: 0, operations: edits.slice(1) }, false);
  assert.match(gone.notices[0].text, /has not answered 1 edit\./);
});
