import assert from "node:assert/strict";
import { test } from "node:test";
import { createStrides } from "../../src/input/strides.js";

test("one walks while keys are down, a tap is a step", () => {
  /** @type {Array<(now: number) => void>} */
  const frames = [];
  /** @type {any} */ (globalThis).requestAnimationFrame = (/** @type {(now: number) => void} */ callback) =>
    frames.push(callback);
  /** @type {Array<[string[], number]>} */
  const walked = [];
  const walk = (/** @type {Iterable<string>} */ ways, /** @type {number} */ seconds) =>
    walked.push([[...ways], seconds]);
  const strides = createStrides(/** @type {any} */ ({ walk }));
  strides.start("forward");
  strides.start("forward");
  strides.start("left");
  assert.deepEqual(
    walked.map(([ways]) => ways),
    [["forward"], ["left"]],
  );
  frames.shift()?.(performance.now() + 60_000);
  assert.deepEqual(walked[2], [["forward", "left"], 0.15]); // however slow the frame
  strides.stop("left");
  frames.shift()?.(performance.now() + 60_016);
  assert.deepEqual(walked[3][0], ["forward"]);
  strides.stop();
  frames.shift()?.(performance.now() + 60_032);
  assert.equal(walked.length, 4);
});
