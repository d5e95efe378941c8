import assert from "node:assert/strict";
import { test } from "node:test";
import { lengthOf } from "../../src/input/measure.js";
import { fakePicture } from "../picture.js";

test("the distance between two points shows while the second is looked for, in looking too, and stays", () => {
  const { hand, press, handlers, take } = fakePicture({ mode: "navigate" });
  hand.setTool("measure");
  press("down", 10);
  press("up", 10);
  handlers.pointed({ face: 12, at: [10.5, 0, 0] });
  assert.deepEqual(take("outline").at(-1), {
    ...{ kind: "outline", isClosed: false, hasDots: true, label: "50.0 cm" },
    places: [
      { x: 10, y: 0 },
      { x: 10.5, y: 0 },
    ],
  });
  press("down", 13);
  press("up", 13);
  assert.equal(take("remark").at(-1).text, "Distance 3.00 m");
  handlers.pointed({ face: 40, at: [40, 0, 0] });
  handlers.moving();
  assert.equal(take("outline").at(-1).label, "3.00 m");
  hand.back();
  assert.deepEqual(take("outline").at(-1).places, []);
});

test("lengths are metres, or centimetres below one", () => {
  assert.deepEqual([lengthOf(0.1234), lengthOf(12.345)], ["12.3 cm", "12.35 m"]);
});
