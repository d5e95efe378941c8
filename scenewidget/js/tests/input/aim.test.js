import assert from "node:assert/strict";
import { test } from "node:test";
import { fire } from "../page.js";
import { fakePicture } from "../picture.js";

test("what the pointer is on is told once, and said on the root", () => {
  const { aim, root, take } = fakePicture();
  aim.setPointer({ x: 12, y: 0 });
  aim.point();
  aim.point();
  assert.deepEqual(take("pointed"), [{ kind: "pointed", face: 12, at: [12, 0, 0] }]);
  assert.equal(root.dataset.hovered, "2");
  aim.setPointer(null);
  aim.point();
  assert.deepEqual(take("pointed"), [{ kind: "pointed", face: null, at: null }]);
  assert.equal(root.dataset.hovered, "");
});

test("keys act on the middle of the picture until the focus goes", () => {
  const { aim, root, take, handlers } = fakePicture();
  assert.equal(aim.target(), null);
  aim.showCross(true);
  assert.deepEqual(take("cross"), [{ kind: "cross", isShown: true }]);
  assert.equal(aim.target(), 50);
  handlers.part({ what: "split" });
  assert.deepEqual(take("act"), [{ kind: "act", what: "split", face: 50, place: { x: 50, y: 25 } }]);
  handlers.choose();
  assert.equal(root.dataset.picked, "10");
  fire(root, "focusout");
  assert.equal(aim.place(), null);
});

test("a wish about a part goes to what is pointed at, else to what is picked, else frames all", () => {
  const { aim, view, press, take, handlers } = fakePicture();
  handlers.part({ what: "frame" });
  assert.deepEqual(view.looked, ["here"]);
  press("down", 2);
  press("up", 2);
  handlers.part({ what: "hide" });
  aim.setPointer({ x: 30, y: 0 });
  handlers.part({ what: "hide" });
  handlers.act_on_picked({ what: "name" });
  assert.deepEqual(
    take("act").map(({ what, face }) => [what, face]),
    [
      ["hide", 2],
      ["hide", 30],
      ["name", 2],
    ],
  );
});

test("what a linked view points at shows while nothing is pointed at here", () => {
  const { aim, root, handlers } = fakePicture();
  handlers.twin_pointed({ face: 40 });
  assert.equal(root.dataset.hovered, "8");
  aim.setPointer({ x: 12, y: 0 });
  aim.point();
  assert.equal(root.dataset.hovered, "2");
});

test("the first point of a cut aims the preview, anything else ends it", () => {
  const { hand, aim, aimed, press } = fakePicture();
  hand.setTool("cut");
  press("down", 2);
  press("up", 2);
  aim.setPointer({ x: 8, y: 0 });
  aim.point();
  assert.deepEqual(aimed.at(-1), [2, 8]);
  hand.letGo();
  assert.deepEqual(aimed.at(-1), [null, null]);
});
