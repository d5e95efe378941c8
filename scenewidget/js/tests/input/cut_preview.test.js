import assert from "node:assert/strict";
import { test } from "node:test";
import { createCutPreview } from "../../src/input/cut_preview.js";

/** A cut tool over a model that only records what is sent, and a picture that only records what is cut off. */
function fake() {
  /** @type {any[]} */
  const sent = [];
  /** @type {(message: any, buffers: any[]) => void} */
  let answer = () => {};
  const model = {
    get: () => 3,
    send: (/** @type {any} */ message) => sent.push(message),
    on: (/** @type {string} */ _, /** @type {any} */ callback) => {
      answer = callback;
    },
    off() {},
  };
  const segments = {
    atomSegment: new Uint32Array(1),
    offcut: /** @type {number[] | null} */ (null),
    pending: { operations: /** @type {any[]} */ ([]) },
    canCut: (/** @type {number} */ a, /** @type {number} */ b) => a !== b && b < 100,
    cutOff(/** @type {number[]} */ faces) {
      this.offcut = faces.length > 0 ? faces : null;
    },
  };
  /** @type {boolean[]} */
  const looks = [];
  const around = /** @type {any} */ ({ model, segments, signal: new AbortController().signal });
  around.send = (/** @type {any} */ { kind }) => kind === "cut_sought" && looks.push(cutting.isLooking);
  const cutting = createCutPreview(around);
  return {
    ...{ cutting, segments, sent, looks },
    /** @param {any} asked @param {number} [bits] */
    answer(asked, bits = 0b11) {
      const buffers = bits ? [Uint8Array.of(bits)] : [new Uint8Array(0)];
      answer({ kind: "cut_preview", request: asked.request, first: 5 }, buffers);
    },
  };
}

test("at rest Python is asked once what would be cut off, and the newest pair counts", (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { cutting, segments, sent, looks, answer } = fake();
  for (const face of [2, 3, 4]) cutting.aim(1, face);
  assert.equal(sent.length, 0);
  context.mock.timers.tick(500);
  assert.equal(sent.length, 1);
  assert.deepEqual(
    [sent[0].kind, sent[0].face_a, sent[0].face_b, sent[0].revision],
    ["preview_cut", 1, 4, 3],
  );
  cutting.aim(1, 6);
  context.mock.timers.tick(500);
  assert.equal(sent.length, 1); // one question at a time
  answer(sent[0]);
  assert.deepEqual(segments.offcut, [5, 6]);
  assert.equal(sent[1].face_b, 6);
  answer(sent[0], 0b1);
  assert.deepEqual(segments.offcut, [5, 6]);
  assert.deepEqual(looks, [true, true]); // it says so all the time
  answer(sent[1], 0);
  assert.equal(segments.offcut, null);
  assert.deepEqual(looks, [true, true, false]);
});

test("what is shown goes with the first point, and over another segment after a while", (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { cutting, segments, sent, answer } = fake();
  const show = () => {
    cutting.aim(1, 4);
    context.mock.timers.tick(500);
    answer(sent.at(-1));
    assert.notEqual(segments.offcut, null);
  };
  show();
  cutting.aim(null, null);
  assert.equal(segments.offcut, null);
  show();
  cutting.aim(1, 200);
  assert.notEqual(segments.offcut, null);
  context.mock.timers.tick(500);
  assert.equal(segments.offcut, null);
  cutting.aim(1, 4);
  context.mock.timers.tick(500);
  cutting.aim(null, null);
  answer(sent.at(-1)); // late
  assert.equal(segments.offcut, null);
});

test("other segments are asked about anew, and while a cut is under way its preview stays", (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { cutting, segments, sent, answer } = fake();
  cutting.aim(1, 4);
  context.mock.timers.tick(500);
  segments.atomSegment = new Uint32Array(1);
  answer(sent[0]);
  assert.equal(segments.offcut, null);
  cutting.aim(1, 4);
  context.mock.timers.tick(500);
  assert.equal(sent.length, 2);
  answer(sent[1]);
  segments.pending.operations.push({ kind: "cut" });
  cutting.aim(null, null);
  assert.notEqual(segments.offcut, null);
  segments.pending.operations.length = 0;
  cutting.aim(null, null);
  assert.equal(segments.offcut, null);
});
