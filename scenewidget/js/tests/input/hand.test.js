import assert from "node:assert/strict";
import { test } from "node:test";
import { fakePicture } from "../picture.js";

test("a drag from part to part becomes a merge at the level shown", () => {
  const { press, take, root } = fakePicture();
  press("down", 2);
  press("move", 30);
  assert.equal(root.dataset.gesture, "link");
  press("up", 30);
  assert.deepEqual(take("edit"), [
    { kind: "edit", edit: { kind: "merge", face: 2, onto_face: 30, level: "base" } },
  ]);
});

test("a right click splits, a right drag moves the picture", () => {
  const { press, take } = fakePicture();
  press("down", 2, { button: 2 });
  press("up", 2, { button: 2 });
  assert.deepEqual(take("edit"), [{ kind: "edit", edit: { kind: "split", face: 2, level: "base" } }]);
  press("down", 2, { button: 2 });
  press("move", 30);
  assert.deepEqual(take("pan"), [{ kind: "pan", dx: 28, dy: 0 }]);
});

test("a cut remembers its ends until Python has made it", () => {
  const { hand, aim, segments, press, take, handlers } = fakePicture();
  handlers.tool({ tool: "cut" });
  hand.points.press = [2, 0, 0];
  assert.deepEqual(take("tool_taken"), [{ kind: "tool_taken", tool: "cut" }]);
  press("down", 2);
  press("move", 8);
  segments.pending.operations.push({ kind: "cut" });
  press("up", 8);
  assert.deepEqual(take("edit"), [{ kind: "edit", edit: { kind: "cut", face_a: 2, face_b: 8 } }]);
  assert.deepEqual(hand.points.seeds?.[1], [8, 0, 0]);
  segments.pending.operations.length = 0;
  aim.stretch();
  assert.equal(hand.points.seeds, null);
});

test("the brush shows what it has gathered as merged", () => {
  const { hand, segments, press, take, root } = fakePicture();
  hand.setTool("brush");
  press("down", 2);
  press("move", 30);
  assert.deepEqual(segments.sketch, { kind: "merge", face: [30], onto_face: 2, level: "base" });
  assert.equal(root.dataset.segments, "9");
  assert.equal(take("hint").at(-1).of, "stroke");
  press("up", 30);
  assert.equal(segments.sketch, null);
  assert.deepEqual(take("edit")[0].edit.face, [30]);
});

test("letting go goes back from what is in hand to the tool, then there is nothing", () => {
  const { hand, press } = fakePicture();
  hand.setTool("cut");
  press("down", 2);
  press("up", 2);
  assert.equal(hand.picked()?.face, 2);
  assert.deepEqual([hand.back(), hand.picked(), hand.tool], [true, null, "cut"]);
  assert.deepEqual([hand.back(), hand.tool], [true, "merge"]);
  assert.equal(hand.back(), false);
});

test("a tool taken twice is put down", () => {
  const { hand } = fakePicture();
  hand.setTool("brush");
  hand.setTool("brush");
  assert.equal(hand.tool, "merge");
});

test("a row of the list picks its segment where segments are the parts, else it is framed", () => {
  const fine = fakePicture();
  fine.handlers.choose_segment({ segment: 3 });
  assert.deepEqual([fine.view.looked, fine.hand.picked()], [[30], null]);
  const whole = fakePicture({ level: "final" });
  whole.handlers.choose_segment({ segment: 3 });
  assert.equal(whole.hand.picked()?.face, 30);
});

test("when segments change, what is in hand is what its face is in now", () => {
  const { hand, view, press } = fakePicture();
  press("down", 2);
  press("up", 2);
  view.partOf = () => 77;
  hand.renew();
  assert.equal(hand.gesture.picked?.part, 77);
  view.partOf = () => 0xffffffff;
  hand.renew();
  assert.equal(hand.gesture.picked, null);
});
