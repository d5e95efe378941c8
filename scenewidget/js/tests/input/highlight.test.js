import assert from "node:assert/strict";
import { test } from "node:test";
import { IDLE } from "../../src/input/gestures.js";
import { heldOf, highlightOf, isCutting } from "../../src/input/highlight.js";
import { NONE } from "../../src/labels/partition.js";

// face f lies in part 10 + f of segment f
const surface = {
  partOf: (/** @type {number} */ face) => 10 + face,
  segmentOf: (/** @type {number} */ face) => face,
  isTarget: (/** @type {number} */ face, /** @type {number} */ onto) => face !== onto,
};
const hit = (/** @type {number} */ face) => ({ face, part: 10 + face, segment: face });
const rest = {
  gesture: IDLE,
  tool: /** @type {const} */ ("merge"),
  face: null,
  listed: null,
  suggested: null,
  offcut: null,
};
const none = { hovered: NONE, picked: NONE, target: NONE, joined: NONE };

test("at rest the part under the pointer lights up, or the segment that the list points at", () => {
  assert.deepEqual(highlightOf(rest, surface), none);
  assert.deepEqual(highlightOf({ ...rest, face: 3, listed: 5 }, surface), { ...none, hovered: 13 });
  assert.deepEqual(highlightOf({ ...rest, listed: 5 }, surface), { ...none, target: 5 });
});

test("what is in hand lights up, and what it would merge with", () => {
  const gesture = { ...IDLE, picked: hit(1) };
  assert.deepEqual(highlightOf({ ...rest, gesture, face: 3 }, surface), {
    ...none,
    picked: 11,
    target: 3,
    joined: 3,
  });
  assert.deepEqual(highlightOf({ ...rest, gesture, face: 1 }, surface), { ...none, picked: 11 });
  const link = { ...IDLE, phase: /** @type {const} */ ("link"), from: hit(2) };
  assert.equal(highlightOf({ ...rest, gesture: link, face: 3 }, surface).picked, 12);
});

test("a stroke of the brush merges with nothing that it passes", () => {
  const gesture = { ...IDLE, stroke: { onto: hit(1), gathered: [hit(2)] } };
  assert.deepEqual(highlightOf({ ...rest, gesture, face: 3 }, surface), { ...none, picked: 11 });
});

test("of a cut its segment lights up, and what it divides off as soon as that is known", () => {
  const situation = {
    ...rest,
    gesture: { ...IDLE, picked: hit(1) },
    tool: /** @type {const} */ ("cut"),
    face: 3,
  };
  assert.deepEqual(highlightOf(situation, surface), { ...none, target: 1 });
  assert.deepEqual(highlightOf({ ...situation, offcut: 9 }, surface), { ...none, target: 9 });
  assert.equal(isCutting(situation), true);
  assert.equal(isCutting({ ...situation, gesture: IDLE }), false);
});

test("a suggestion lights up until something is in hand", () => {
  const suggested = { face: 4, onto: 6 };
  assert.deepEqual(highlightOf({ ...rest, suggested }, surface), { ...none, picked: 14, target: 6 });
  assert.deepEqual(highlightOf({ ...rest, suggested: { face: 4, onto: -1 } }, surface), {
    ...none,
    picked: 14,
  });
  const gesture = { ...IDLE, picked: hit(1) };
  assert.deepEqual(highlightOf({ ...rest, suggested, gesture }, surface), { ...none, picked: 11 });
  assert.equal(heldOf(gesture)?.face, 1);
});

test("nothing blinks under a brush that paints", () => {
  const gesture = { ...IDLE, phase: /** @type {const} */ ("paint") };
  assert.deepEqual(highlightOf({ ...rest, gesture, tool: "paint", face: 3 }, surface), none);
});
