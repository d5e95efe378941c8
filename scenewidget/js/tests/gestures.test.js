import assert from "node:assert/strict";
import { test } from "node:test";
import { IDLE, step } from "../src/gestures.js";

/** @typedef {import("../src/gestures.js").Action} Action */
/** @typedef {import("../src/gestures.js").PointerEventLike} PointerEventLike */

const chair = { face: 10, part: 1, segment: 1 };
const table = { face: 20, part: 2, segment: 2 };

/**
 * @param {Array<Partial<PointerEventLike> & { type: PointerEventLike["type"] }>} events
 * @param {import("../src/gestures.js").Mode} mode
 */
function play(events, mode = "edit") {
  let gesture = IDLE;
  /** @type {Action[]} */
  const actions = [];
  for (const event of events) {
    const [next, now] = step(gesture, { id: 1, x: 0, y: 0, button: 0, ...event }, mode);
    gesture = next;
    actions.push(...now);
  }
  return { gesture, actions };
}

test("dragging orbits; with Shift or the right button it pans", () => {
  const drag = (/** @type {object} */ down) =>
    play(
      [
        { type: "down", ...down },
        { type: "move", x: 5, y: 2 },
        { type: "up", x: 5, y: 2 },
      ],
      "navigate",
    ).actions;
  assert.deepEqual(drag({ hit: chair }), [{ kind: "orbit", dx: 5, dy: 2 }]);
  assert.deepEqual(drag({ shift: true }), [{ kind: "pan", dx: 5, dy: 2 }]);
  assert.deepEqual(drag({ button: 2, hit: chair }), [{ kind: "pan", dx: 5, dy: 2 }]);
});

test("dragging from part to part merges", () => {
  const { actions, gesture } = play([
    { type: "down", hit: chair },
    { type: "move", x: 30 },
    { type: "up", x: 60, hit: table },
  ]);
  assert.deepEqual(actions, [{ kind: "merge", face: 10, onto: 20 }]);
  assert.deepEqual(gesture, IDLE);
});

test("clicking one part, then another, merges; the same part again lets go", () => {
  const click = (/** @type {typeof chair} */ hit) => [
    { type: "down", hit },
    { type: "up", hit },
  ];
  /** @type {any} */
  const both = [...click(chair), ...click(table)];
  assert.deepEqual(play(both).actions, [
    { kind: "click", face: 10 },
    { kind: "merge", face: 10, onto: 20 },
  ]);
  /** @type {any} */
  const twice = [...click(chair), ...click(chair)];
  assert.deepEqual(play(twice).actions, [{ kind: "click", face: 10 }]);
  assert.equal(play(twice).gesture.picked, null);
});

test("a key chooses like a click, and Escape lets go of what was picked", () => {
  assert.deepEqual(
    play([
      { type: "choose", hit: chair },
      { type: "choose", hit: null },
      { type: "choose", hit: table },
    ]).actions,
    [
      { kind: "click", face: 10 },
      { kind: "merge", face: 10, onto: 20 },
    ],
  );
  assert.deepEqual(play([{ type: "choose", hit: chair }, { type: "cancel" }]).gesture, IDLE);
});

test("a part that lies in two segments can bring one half to the other", () => {
  const half = { ...chair, face: 11, segment: 2 };
  assert.deepEqual(
    play([
      { type: "down", hit: chair },
      { type: "move", x: 30 },
      { type: "up", x: 60, hit: half },
    ]).actions,
    [{ kind: "merge", face: 10, onto: 11 }],
  );
});

test("a picked part stays picked while the room is turned", () => {
  const { actions, gesture } = play([
    { type: "choose", hit: chair },
    { type: "down", hit: null },
    { type: "move", x: 30 },
    { type: "up", x: 30 },
  ]);
  assert.deepEqual(gesture.picked, chair);
  assert.equal(actions.at(-1)?.kind, "orbit");
});

test("a right click splits, a right drag pans from where it began", () => {
  assert.deepEqual(
    play([
      { type: "down", button: 2, hit: chair },
      { type: "move", x: 2 },
      { type: "up", x: 2, hit: chair },
    ]).actions,
    [{ kind: "split", face: 10 }],
  );
  assert.deepEqual(
    play([
      { type: "down", button: 2, hit: chair },
      { type: "move", x: 9 },
      { type: "up", x: 9, hit: chair },
    ]).actions,
    [{ kind: "pan", dx: 9, dy: 0 }],
  );
});

test("released outside, on the same part, cancelled or lost, nothing is edited", () => {
  /** @type {any[]} */
  const begun = [
    { type: "down", hit: chair },
    { type: "move", x: 30 },
  ];
  for (const end of [
    { type: "up", x: 900, hit: null },
    { type: "up", x: 30, hit: { ...chair, face: 11 } },
    { type: "cancel" },
  ]) {
    const { actions, gesture } = play([...begun, end]);
    assert.deepEqual([actions, gesture], [[], IDLE]);
  }
});

test("on the background, and with Shift, a drag orbits in edit mode, too", () => {
  for (const down of [{ hit: null }, { hit: chair, shift: true }]) {
    assert.deepEqual(
      play([
        { type: "down", ...down },
        { type: "move", x: 8 },
        { type: "up", x: 8, hit: table },
      ]).actions,
      [{ kind: "orbit", dx: 8, dy: 0 }],
    );
  }
});

test("two fingers zoom and pan, and no edit comes of them", () => {
  const touch = { isTouch: true };
  const { actions, gesture } = play([
    { type: "down", id: 1, x: 0, hit: chair, ...touch },
    { type: "down", id: 2, x: 100, hit: table, ...touch },
    { type: "move", id: 2, x: 200, ...touch },
    { type: "up", id: 1, x: 0, hit: chair, ...touch },
    { type: "up", id: 2, x: 200, hit: table, ...touch },
  ]);
  assert.deepEqual(actions, [
    { kind: "pan", dx: 50, dy: 0 },
    { kind: "zoom", factor: 0.5, x: 100, y: 0 },
  ]);
  assert.deepEqual(gesture.phase, "idle");
});

test("pointers that were never pressed change nothing", () => {
  assert.deepEqual(
    play([
      { type: "move", x: 5 },
      { type: "up", x: 5 },
    ]),
    { gesture: IDLE, actions: [] },
  );
});
