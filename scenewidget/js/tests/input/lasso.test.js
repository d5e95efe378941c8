import assert from "node:assert/strict";
import { test } from "node:test";
import { fakePicture } from "../picture.js";

const frame = () => new Promise((drawn) => setTimeout(drawn, 5));

/** A picture with a lasso in hand, and a line around the faces between two places. */
function lassoing(changes = {}) {
  const picture = fakePicture();
  picture.hand.setTool("lasso");
  picture.handlers.option({ changes });
  picture.view.placeOf = (/** @type {number[]} */ [x, y]) => ({ x, y });
  picture.view.pointBefore = (/** @type {{ x: number, y: number }} */ { x, y }) => [x, y, 0];
  const corners = (/** @type {number} */ low, /** @type {number} */ high) =>
    [
      [low, -9],
      [high, -9],
      [high, 9],
      [low, 9],
    ].map(([x, y]) => ({ x, y }));
  const feed = (/** @type {any} */ type, /** @type {{ x: number, y: number }} */ place) =>
    picture.hand.feed({ type, id: 1, button: 0, ...place, hit: picture.view.hitAt(place) });
  const drag = (/** @type {number} */ low, /** @type {number} */ high) => {
    const [first, ...rest] = corners(low - 0.5, high + 0.5);
    feed("down", first);
    for (const place of rest) feed("move", place);
    feed("up", rest[2]);
  };
  return { ...picture, corners, feed, drag };
}

test("what is seen within a line becomes a segment, in one edit, and shows while it is drawn", async () => {
  const { feed, corners, segments, take, hand } = lassoing();
  const [a, b, c, d] = corners(11.5, 15.5);
  feed("down", a);
  for (const place of [b, c, d]) feed("move", place);
  await frame();
  const edit = { kind: "paint", ranges: [12, 16], onto_face: null };
  assert.deepEqual(segments.sketch, edit);
  assert.equal(take("outline").at(-1)?.places.length, 4);
  feed("up", d);
  assert.equal(segments.sketch, null);
  assert.deepEqual(take("edit"), [{ kind: "edit", edit }]);
  assert.equal(hand.gesture.phase, "idle");
});

test("a line may end where it began", () => {
  const { feed, corners, take } = lassoing();
  const [a, b, c, d] = corners(11.5, 15.5);
  feed("down", a);
  for (const place of [b, c, d, a]) feed("move", place);
  feed("up", a);
  assert.deepEqual(take("edit")[0].edit.ranges, [12, 16]);
});

test("through, it takes what isn't seen as well, but nothing that isn't drawn", () => {
  const { drag, take, view } = lassoing({ isThrough: true });
  view.sight.isSeen = () => false;
  view.facesWithin = () => new Set();
  drag(12, 15);
  assert.deepEqual(take("edit")[0].edit.ranges, [12, 13, 14, 16]);
});

test("of one segment alone, it takes those of the one that has most within", () => {
  const { drag, take } = lassoing({ isOfOne: true });
  drag(17, 26);
  assert.deepEqual(take("edit")[0].edit.ranges, [20, 27]);
});

test("corners are set by clicks, follow the scan, and close at the first one", () => {
  const { feed, corners, view, take, hand, handlers } = lassoing();
  const [a, b, c] = corners(11.5, 40.5);
  for (const place of [a, b, c]) {
    feed("down", place);
    feed("up", place);
  }
  view.placeOf = (/** @type {number[]} */ [x, y]) => ({ x: x + 1, y });
  handlers.moving();
  assert.deepEqual(take("outline").at(-1).places[0], { x: 12.5, y: -9 });
  assert.match(take("hint").at(-1)?.text ?? hand.drawingHint, /first corner/);
  const first = { x: 12.5, y: -9 };
  feed("down", first);
  feed("up", first);
  const { ranges, onto_face } = take("edit")[0].edit;
  assert.equal(onto_face, null);
  assert.ok(ranges[0] > 11 && ranges.at(-1) < 43);
  assert.equal(hand.drawingHint?.includes("draw around"), true);
});

test("a key sets corners and closes; Escape forgets them, then puts the tool down", () => {
  const { hand, corners, take, handlers, root } = lassoing();
  for (const place of corners(19.5, 24.5)) hand.feed({ type: "choose", id: -1, ...place });
  handlers.finish();
  assert.deepEqual(take("edit")[0].edit.ranges, [20, 25]);
  hand.feed({ type: "choose", id: -1, x: 5, y: 5 });
  assert.deepEqual([hand.back(), root.dataset.tool], [true, "lasso"]);
  assert.deepEqual([hand.back(), root.dataset.tool], [true, "merge"]);
});

test("an outline around nothing says so", () => {
  const { drag, take } = lassoing();
  drag(94, 98);
  assert.equal(take("remark").at(-1).text, "There is nothing within this outline");
});
