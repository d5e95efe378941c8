import assert from "node:assert/strict";
import { test } from "node:test";
import { fitted, planeThrough } from "../../src/input/slice.js";
import { fakePicture } from "../picture.js";

const frame = () => new Promise((drawn) => setTimeout(drawn, 5));

/** A picture with a plane in hand; a point lies as high as its place is low. */
function slicing(changes = {}) {
  const picture = fakePicture();
  picture.hand.setTool("slice");
  picture.handlers.option({ changes });
  picture.view.pointAt = (/** @type {{ x: number, y: number }} */ { x, y }) => (x < 90 ? [x, y, 0] : null);
  const click = (/** @type {number} */ x, /** @type {number} */ y) => {
    for (const type of /** @type {const} */ (["down", "up"]))
      picture.hand.feed({ type, id: 1, x, y, button: 0, hit: picture.view.hitAt({ x }) });
  };
  const hover = (/** @type {number} */ x, /** @type {number} */ y) =>
    picture.handlers.pointed({ face: x, at: [x, y, 0] });
  return { ...picture, click, hover };
}

test("three points divide the segment of the first; the smaller side comes off, and shows before", async () => {
  const { view, click, hover, segments, take } = slicing();
  view.pointAt = (/** @type {{ x: number, y: number }} */ { x, y }) => [17.5, x, y];
  click(12, 0);
  click(13, 0);
  hover(14, 8);
  const plane = { point: [17.5, 12, 0], normal: [1, 0, 0] };
  view.pointAt = () => [17.5, 14, 8];
  await frame();
  click(14, 8);
  const [{ edit }] = take("edit");
  assert.deepEqual([edit.kind, edit.face, edit.off], ["slice", 10, [18, 20]]);
  // in the scan's own axes
  assert.deepEqual(edit.point, [plane.point[2], plane.point[0], plane.point[1]]);
  assert.deepEqual(edit.normal.map(Math.abs), [0, 1, 0]);
  assert.equal(segments.sketch, null);
});

test("while the last point is looked for, what would come off is shown", async () => {
  const { view, click, handlers, segments } = slicing();
  view.pointAt = (/** @type {{ x: number, y: number }} */ { x, y }) => [17.5, x, y];
  click(12, 0);
  click(13, 0);
  handlers.pointed({ face: 14, at: [17.5, 14, 8] });
  await frame();
  assert.deepEqual(segments.sketch, { kind: "paint", ranges: [18, 20], onto_face: null });
  handlers.pointed({ face: null, at: null });
  await frame();
  assert.equal(segments.sketch, null);
});

test("points on a line, and planes that leave a segment whole, are refused with the reason", () => {
  const { view, click, take } = slicing();
  for (const x of [12, 13, 14]) click(x, 0);
  assert.match(take("remark").at(-1).text, /lie on a line/);
  view.pointAt = (/** @type {{ x: number, y: number }} */ { x, y }) => [99, x, y];
  click(12, 0);
  click(13, 0);
  click(14, 8);
  assert.match(take("remark").at(-1).text, /one side/);
});

test("a wall gives its own plane, so far in front of it", () => {
  const { view, click, take } = slicing({ plane: "wall", offset: 150 });
  view.sight.awayFrom = () => 0;
  click(12, 0);
  click(50, 0);
  assert.match(take("remark").at(-1).text, /one side/); // all of the strip lies below a plane above it
  const { vertices, faces } = view.mesh;
  const flat = fitted({ vertices, faces }, [2, 3]);
  assert.ok(flat && Math.abs(flat.normal[2] - 1) < 0.01 && Math.abs(flat.point[0] - 2.5) < 1e-6);
});

test("a drag turns the room, an unlabeled surface has no segment to slice", () => {
  const { hand, segments, press, click, take } = slicing();
  press("down", 12);
  press("move", 40);
  press("up", 60);
  assert.equal(take("orbit").length > 0, true);
  segments.baseOf = () => 0xffffffff;
  click(12, 0);
  assert.match(take("remark").at(-1).text, /unlabeled/);
  assert.match(hand.drawingHint ?? "", /three points/);
});

test("three points give their plane", () => {
  const plane = planeThrough([
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
  ]);
  assert.deepEqual(plane, { point: [0, 0, 1], normal: [0, 0, 1] });
});
