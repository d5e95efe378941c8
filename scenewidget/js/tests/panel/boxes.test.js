import assert from "node:assert/strict";
import { test } from "node:test";
import { boxLines, createBoxes } from "../../src/panel/boxes.js";
import { standIn } from "../../src/wire/saved_model.js";
import { openPage } from "../page.js";

openPage();

test("boxes are lines while they are wanted, with measures at the one that is pointed at", () => {
  const row = (/** @type {number} */ x) => [...[x, 0, 0], ...[1, 0, 0], ...[0, 1, 0], ...[0, 0, 1]];
  const model = standIn({
    boxes: false,
    _headers: { segment_box: { dtype: "float32", shape: [2, 12] } },
    _segment_box: new Float32Array([...row(0), ...row(5)]),
  });
  const view = /** @type {any} */ ({
    mesh: {},
    hidden: null,
    partition: {
      faceAtom: new Uint32Array([0, 1]),
      atomSegment: new Uint32Array([0, 1]),
      segmentColors: new Uint8Array(6),
    },
    fromOwn: (/** @type {any} */ point) => point,
    placeOf: (/** @type {number[]} */ [x, y]) => ({ x, y }),
  });
  const around = /** @type {any} */ ({ model, view, segments: { isPreview: false } });
  const panel = createBoxes();
  const shown = (/** @type {number | null} */ face) => {
    panel.show(boxLines(around, face));
    return [...panel.element.children].map((node) => node.getAttribute("class"));
  };
  assert.deepEqual(shown(1), []);
  model.set("boxes", true);
  assert.deepEqual(shown(null), ["sw-box", "sw-box"]);
  assert.deepEqual(shown(1), ["sw-box", "sw-box sw-box-pointed", "sw-outline-label"]);
  assert.equal(panel.element.children[2].textContent, "2.00 × 2.00 × 2.00 m");
  view.hidden = new Uint8Array([1, 0]);
  assert.deepEqual(shown(null), ["sw-box"]);
  around.segments.isPreview = true;
  assert.deepEqual(shown(null), []);
});
