import assert from "node:assert/strict";
import { test } from "node:test";
import { IDLE, step } from "../../src/input/gestures.js";

/** @typedef {import("../../src/input/gestures.js").Action} Action */
/** @typedef {import("../../src/input/gestures.js").PointerEventLike} PointerEventLike */

const chair = { face: 10, part: 1, segment: 1 };
const table = { face: 20, part: 2, segment: 2 };

const lamp = { face: 30, part: 3, segment: 3 };

/**
 * @param {Array<Partial<PointerEventLike> & { type: PointerEventLike["type"] }>} events
 * @param {import("../../src/input/gestures.js").Mode} mode
 * @param {import("../../src/input/gestures.js").Tool} [tool]
 */
function play(events, mode = "edit", tool = "merge") {
  let gesture = IDLE;
  /** @type {Action[]} */
  const actions = [];
  for (const event of events) {
    const [next, now] = step(gesture, { id: 1, x: 0, y: 0, button: 0, ...event }, mode, tool);
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

/** @type {Array<Partial<PointerEventLike> & { type: PointerEventLike["type"] }>} */
const stroke = [
  { type: "down", hit: chair },
  { type: "move", x: 30, hit: table },
  { type: "move", x: 40, hit: table },
  { type: "move", x: 50, hit: null },
  { type: "move", x: 60, hit: lamp },
  { type: "move", x: 70, hit: chair },
];

test("a brush puts all that it passes over onto the first part, in one merge", () => {
  const merge = { kind: "merge", face: [20, 30], onto: 10 };
  const { actions, gesture } = play([...stroke, { type: "up", x: 0, hit: chair }], "edit", "brush");
  assert.deepEqual(actions, [merge]);
  assert.deepEqual(gesture, IDLE);
  const held = [{ ...stroke[0], brush: true }, ...stroke.slice(1)];
  assert.deepEqual(play([...held, { type: "up", hit: lamp }]).actions, [merge]);
  assert.deepEqual(play([...stroke, { type: "up", hit: null }], "edit", "brush").actions, [merge]);
});

test("a brush released outside, cancelled or without a second part edits nothing", () => {
  assert.deepEqual(play([...stroke, { type: "up", isOutside: true }], "edit", "brush").actions, []);
  const { actions, gesture } = play([...stroke, { type: "cancel" }, { type: "up" }], "edit", "brush");
  assert.deepEqual([actions, gesture], [[], IDLE]);
  assert.deepEqual(
    play([...stroke.slice(0, 1), { type: "up", x: 9, hit: chair }], "edit", "brush").actions,
    [],
  );
});

test("a brush gathers by clicks and keys, too, until it is told to finish", () => {
  const click = (/** @type {typeof chair} */ hit) =>
    /** @type {const} */ ([
      { type: "down", hit },
      { type: "up", hit },
    ]);
  const open = play([...click(chair), ...click(table), { type: "choose", hit: lamp }], "edit", "brush");
  assert.deepEqual(open.actions, []);
  assert.deepEqual(open.gesture.stroke, { onto: chair, gathered: [table, lamp] });
  const [rest, actions] = step(open.gesture, { type: "finish", id: -1, x: 0, y: 0 }, "edit", "brush");
  assert.deepEqual([rest, actions], [IDLE, [{ kind: "merge", face: [20, 30], onto: 10 }]]);
  const [, grouped] = step(open.gesture, { type: "group", id: -1, x: 0, y: 0 }, "edit", "brush");
  assert.deepEqual(grouped, [{ kind: "group", face: [20, 30], onto: 10 }]);
  assert.deepEqual(play([{ type: "finish" }]).actions, []);
});

test("the cut tool tells two points, by a drag or by two clicks", () => {
  const here = { face: 10, part: 1, segment: 1 };
  const there = { face: 19, part: 1, segment: 1 };
  const cut = [{ kind: "cut", face: 10, onto: 19 }];
  const drag = play(
    [
      { type: "down", hit: here },
      { type: "move", x: 30, hit: there },
      { type: "up", x: 60, hit: there },
    ],
    "edit",
    "cut",
  );
  assert.deepEqual(drag.actions, cut);
  const keys = play(
    [
      { type: "choose", hit: here },
      { type: "choose", hit: there },
    ],
    "edit",
    "cut",
  );
  assert.deepEqual(keys.actions.slice(1), cut);
  const same = play(
    [
      { type: "choose", hit: here },
      { type: "choose", hit: here },
    ],
    "edit",
    "cut",
  );
  assert.deepEqual(same.actions.slice(1), []);
});

const finger = { isTouch: true };

test("a finger orbits in both modes once it has left its place", () => {
  for (const mode of /** @type {const} */ (["navigate", "edit"])) {
    const { actions, gesture } = play(
      [
        { type: "down", hit: chair, ...finger },
        { type: "move", x: 6, ...finger },
        { type: "move", x: 12, ...finger },
        { type: "move", x: 15, hit: table, ...finger },
        { type: "up", x: 3, hit: table, ...finger },
      ],
      mode,
    );
    assert.deepEqual(actions, [
      { kind: "orbit", dx: 12, dy: 0 },
      { kind: "orbit", dx: 3, dy: 0 },
    ]);
    assert.deepEqual(gesture, IDLE);
  }
});

test("a tap points while looking; while editing a tap, then another, merges or cuts", () => {
  const tap = (/** @type {typeof chair | null} */ hit) =>
    /** @type {const} */ ([
      { type: "down", hit, ...finger },
      { type: "move", x: 6, hit, ...finger },
      { type: "up", x: 6, hit, ...finger },
    ]);
  assert.deepEqual(play([...tap(chair), ...tap(table)], "navigate").actions, [
    { kind: "click", face: 10 },
    { kind: "click", face: 20 },
  ]);
  assert.deepEqual(play([...tap(chair), ...tap(table)]).actions[1], { kind: "merge", face: 10, onto: 20 });
  assert.deepEqual(play([...tap(chair), ...tap(table)], "edit", "cut").actions[1], {
    ...{ kind: "cut", face: 10, onto: 20 },
  });
  assert.deepEqual(play([...tap(chair), ...tap(null)]).gesture, IDLE);
});

test("a part that was tapped stays picked while fingers turn, pan and zoom", () => {
  const { gesture, actions } = play([
    { type: "down", hit: chair, ...finger },
    { type: "up", hit: chair, ...finger },
    { type: "down", id: 2, hit: table, ...finger },
    { type: "down", id: 3, x: 100, hit: lamp, ...finger },
    { type: "move", id: 3, x: 150, hit: lamp, ...finger },
    { type: "up", id: 3, x: 150, hit: lamp, ...finger },
    { type: "up", id: 2, hit: table, ...finger },
  ]);
  assert.deepEqual(gesture.picked, chair);
  assert.deepEqual(new Set(actions.map(({ kind }) => kind)), new Set(["click", "pan", "zoom"]));
});

test("a long press splits, and its release does nothing more", () => {
  /** @type {any[]} */
  const long = [
    { type: "down", hit: chair },
    { type: "hold" },
    { type: "move", x: 30 },
    { type: "up", hit: chair },
  ];
  const split = [{ kind: "split", face: 10 }];
  assert.deepEqual(play(long), { gesture: IDLE, actions: split }); // of a pen
  assert.deepEqual(play(long.map((event) => ({ ...event, ...finger }))), { gesture: IDLE, actions: split });
  const moved = [long[0], { type: "move", x: 30, ...finger }, ...long.slice(1)];
  assert.deepEqual(play(moved.map((event) => ({ ...event, ...finger }))).actions.at(-1)?.kind, "orbit");
  assert.deepEqual(play([{ ...long[0], ...finger }, long[1]], "navigate").actions, []);
});

test("with the brush in hand a finger paints, and a second one ends that", () => {
  const painted = stroke.map((event) => ({ ...event, ...finger }));
  const { actions } = play([...painted, { type: "up", hit: lamp, ...finger }], "edit", "brush");
  assert.deepEqual(actions, [{ kind: "merge", face: [20, 30], onto: 10 }]);
  const two = play([...painted, { type: "down", id: 2, x: 90, hit: lamp, ...finger }], "edit", "brush");
  assert.equal(two.gesture.phase, "pinch");
});
