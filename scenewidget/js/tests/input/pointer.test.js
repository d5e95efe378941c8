import assert from "node:assert/strict";
import { test } from "node:test";
import { listenToPointer, placesBetween } from "../../src/input/pointer.js";
import { fire, openPage, PageElement } from "../page.js";

openPage();

function fake() {
  const [root, canvas] = [new PageElement("div"), new PageElement("canvas")];
  root.append(canvas);
  canvas.clientWidth = canvas.clientHeight = 100;
  /** @type {any} */ (document).under = canvas;
  /** @type {any[]} */
  const fed = [];
  const hand = /** @type {any} */ ({
    ...{ gesture: { phase: "idle", stroke: null }, points: {} },
    feed: (/** @type {any} */ event) => fed.push(event),
    letGo: () => fed.push("let go"),
  });
  const aim = /** @type {any} */ ({ pointer: null, isKeyboard: false, nPoints: 0 });
  Object.assign(aim, { point: () => aim.nPoints++, stretch() {}, showCross() {} });
  aim.setPointer = (/** @type {any} */ place) => {
    aim.pointer = place;
  };
  const view = {
    hitAt: (/** @type {{ x: number }} */ { x }) => ({ face: x }),
    pointAt: () => [0, 0, 0],
    recentre() {},
  };
  const life = new AbortController();
  const model = { get: () => "edit" };
  listenToPointer(/** @type {any} */ ({ model, view, root, canvas, hand, aim, signal: life.signal }));
  const act = (/** @type {string} */ type, /** @type {number} */ x, more = {}) =>
    fire(canvas, type, { clientX: x, clientY: 0, pointerId: 1, pointerType: "mouse", ...more });
  return { fed, hand, aim, act };
}

test("places between two events are no farther apart than a step", () => {
  const places = [...placesBetween({ x: 0, y: 0 }, { x: 12, y: 0 }, 5)].map(({ x }) => x);
  assert.deepEqual(places, [4, 8]);
  assert.deepEqual([...placesBetween({ x: 0, y: 0 }, { x: 4, y: 0 }, 5)], []);
});

test("a pointer that only moves points, one that is down feeds the gesture", () => {
  const { fed, hand, aim, act } = fake();
  act("pointermove", 4);
  assert.deepEqual([fed, aim.nPoints, aim.pointer.x], [[], 1, 4]);
  act("pointerdown", 4);
  hand.gesture.phase = "press";
  act("pointermove", 9);
  assert.deepEqual(
    fed.map(({ type, x, hit }) => [type, x, hit.face]),
    [
      ["down", 4, 4],
      ["move", 9, 9],
    ],
  );
});

test("outside the picture there is nothing to hit", () => {
  const { fed, hand, aim, act } = fake();
  hand.gesture.phase = "link";
  /** @type {any} */ (document).under = null;
  act("pointerup", 9);
  assert.deepEqual([fed[0].hit, fed[0].isOutside, aim.pointer], [null, true, null]);
});

test("a fast brush misses nothing in between", () => {
  const { fed, hand, aim, act } = fake();
  hand.gesture = { phase: "brush", stroke: {} };
  aim.pointer = { x: 0, y: 0 };
  act("pointermove", 12);
  assert.deepEqual(
    fed.map(({ x }) => x),
    [4, 8, 12],
  );
});

test("a finger that stays is a long press, and what is taken away is let go", (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { fed, hand, act } = fake();
  act("pointerdown", 4, { pointerType: "touch" });
  t.mock.timers.tick(600);
  assert.equal(fed.at(-1).type, "hold");
  act("lostpointercapture", 4);
  assert.notEqual(fed.at(-1), "let go");
  hand.gesture.phase = "link";
  act("lostpointercapture", 4);
  assert.equal(fed.at(-1), "let go");
});
