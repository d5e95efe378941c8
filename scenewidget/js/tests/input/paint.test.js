import assert from "node:assert/strict";
import { test } from "node:test";
import { fakePicture } from "../picture.js";

/** A picture with a brush of one pixel in hand. */
function painting(changes = {}) {
  const picture = fakePicture();
  picture.hand.setTool("paint");
  picture.handlers.option({ changes: { radius: { px: 1, cm: 2 }, ...changes } });
  return picture;
}

/** Until the page has been drawn. */
const frame = () => new Promise((drawn) => setTimeout(drawn, 5));

test("a stroke inside a segment makes its faces a new one, in one edit on release", async () => {
  const { segments, press, take, root } = painting();
  press("down", 12);
  assert.equal(root.dataset.gesture, "paint");
  assert.equal(segments.sketch, null);
  await frame();
  const { draft, ...sketch } = segments.sketch;
  assert.deepEqual(sketch, { kind: "paint", ranges: [11, 14], onto_face: null });
  assert.equal(draft.faceAtom, null); // it is painted on when it is shown
  press("move", 14);
  assert.deepEqual(take("edit"), []);
  press("up", 15);
  assert.equal(segments.sketch, null);
  assert.deepEqual(take("edit"), [
    { kind: "edit", edit: { kind: "paint", ranges: [11, 17], onto_face: null } },
  ]);
});

test("a stroke that leaves the segment brings the others' faces to it", async () => {
  const { segments, press, take } = painting();
  press("down", 18);
  press("move", 19);
  press("move", 20);
  await frame();
  assert.equal(segments.sketch.onto_face, 18);
  press("up", 21);
  assert.deepEqual(take("edit")[0].edit, { kind: "paint", ranges: [17, 23], onto_face: 18 });
});

test("a finger that paints for longer than a press is long loses nothing", () => {
  const { hand, press, take } = painting();
  press("down", 12, { isTouch: true });
  hand.feed({ type: "hold", id: -1, x: 0, y: 0 });
  press("move", 14, { isTouch: true });
  press("up", 15, { isTouch: true });
  assert.deepEqual(take("edit")[0].edit.ranges, [11, 17]);
});

test("it stops at a crease, and doesn't go on beyond it", () => {
  const { press, take } = painting();
  press("down", 43);
  for (const x of [44, 45, 46, 47]) press("move", x);
  press("up", 48);
  assert.deepEqual(take("edit")[0].edit.ranges, [42, 45]);
});

test("with Alt, or without sticking, it takes whatever is seen under it", () => {
  for (const [changes, more] of [
    [{}, { isFree: true }],
    [{ sticks: false }, {}],
  ]) {
    const { press, take } = painting(changes);
    press("down", 44, more);
    press("move", 46, more);
    press("up", 60, more);
    assert.deepEqual(take("edit")[0].edit.ranges, [43, 48, 59, 62]);
  }
});

test("a brush of centimetres reaches so far on the surface", () => {
  const { press, take } = painting({ unit: "cm", radius: { px: 1, cm: 3 } });
  press("down", 12);
  press("up", 12);
  assert.deepEqual(take("edit")[0].edit.ranges, [9, 16]);
});

test("set to take away, it gives faces of the segment it began on to the one that they touch most", () => {
  const { press, take } = painting({ takesAway: true, radius: { px: 2, cm: 2 } });
  press("down", 18);
  press("up", 19);
  assert.deepEqual(take("edit")[0].edit, { kind: "paint", ranges: [16, 20], onto_face: 20 });
});

test("Escape drops a stroke; on the background there is none", () => {
  const { hand, segments, press, take } = painting();
  press("down", 12);
  hand.letGo();
  assert.equal(segments.sketch, null);
  press("down", 95);
  press("up", 95);
  assert.deepEqual(take("edit"), []);
});

test("a key dabs once", () => {
  const { hand, take, view } = painting();
  hand.feed({ type: "choose", id: -1, x: 40, y: 0, hit: view.hitAt({ x: 40 }) });
  assert.deepEqual(take("edit")[0].edit, { kind: "paint", ranges: [39, 42], onto_face: 40 });
});

test("the outline of the brush follows the pointer, as large as the brush is", () => {
  const { aim, handlers, take } = painting({ unit: "cm" });
  aim.setPointer({ x: 30, y: 5 });
  aim.stretch();
  assert.deepEqual(take("ring").at(-1), { kind: "ring", place: { x: 30, y: 5 }, radius: 2 });
  handlers.option({ changes: { unit: "px" } });
  handlers.resize({ way: 1 });
  assert.equal(take("ring").at(-1)?.radius, 2);
  aim.setPointer({ x: 95, y: 5 });
  handlers.option({ changes: { unit: "cm" } });
  assert.equal(take("ring").at(-1)?.place, null);
});
