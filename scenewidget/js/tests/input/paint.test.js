import assert from "node:assert/strict";
import { test } from "node:test";
import { fakePicture } from "../picture.js";

test("a stroke inside a segment makes its faces a new one, in one edit on release", () => {
  const { hand, segments, press, take, root } = fakePicture();
  hand.setTool("paint");
  press("down", 12);
  assert.equal(root.dataset.gesture, "paint");
  assert.deepEqual(segments.sketch, { kind: "paint", ranges: [11, 14], onto_face: null });
  press("move", 16);
  assert.deepEqual(take("edit"), []);
  press("up", 16);
  assert.equal(segments.sketch, null);
  const edit = { kind: "paint", ranges: [11, 14, 15, 18], onto_face: null };
  assert.deepEqual(take("edit"), [{ kind: "edit", edit }]);
});

test("a stroke that leaves the segment brings the others' faces to it", () => {
  const { hand, segments, press, take } = fakePicture();
  hand.setTool("paint");
  press("down", 18);
  press("move", 22);
  assert.equal(segments.sketch.onto_face, 18);
  press("up", 22);
  assert.deepEqual(take("edit")[0].edit, { kind: "paint", ranges: [17, 20, 21, 24], onto_face: 18 });
});

test("Escape drops a stroke; on the background there is none", () => {
  const { hand, segments, press, take } = fakePicture();
  hand.setTool("paint");
  press("down", 12);
  hand.letGo();
  assert.equal(segments.sketch, null);
  press("down", 95);
  press("up", 95);
  assert.deepEqual(take("edit"), []);
});

test("a key dabs once", () => {
  const { hand, take, view } = fakePicture();
  hand.setTool("paint");
  hand.feed({ type: "choose", id: -1, x: 40, y: 0, hit: view.hitAt({ x: 40 }) });
  assert.deepEqual(take("edit")[0].edit, { kind: "paint", ranges: [39, 42], onto_face: 40 });
});
