/** A picture to point at, with a hand and an aim on it, for tests in Node. */

import { createAim } from "../src/input/aim.js";
import { createHand } from "../src/input/hand.js";
import { fakeDispatcher, fakeModel, openPage, PageElement } from "./page.js";

openPage();

/** A picture 100 wide whose face at x is x; five faces a part, ten a segment. Hand and aim on it. */
export function fakePicture({ mode = "edit", level = "base" } = {}) {
  const dispatcher = fakeDispatcher();
  const root = /** @type {any} */ (new PageElement("div"));
  const view = /** @type {any} */ ({
    ...{ size: { width: 100, height: 50 }, isMoving: false, look: {}, partition: null, looked: [] },
    faceAt: (/** @type {{ x: number }} */ { x }) => (x < 90 ? x : null),
    pointAt: (/** @type {{ x: number }} */ { x }) => (x < 90 ? [x, 0, 0] : null),
    facesAround: (/** @type {{ x: number }} */ { x }) =>
      new Set([x - 1, x, x + 1].filter((face) => face >= 0 && face < 90)),
    placeOf: (/** @type {number[]} */ [x]) => ({ x, y: 0 }),
    partOf: (/** @type {number} */ face) => Math.floor(face / 5),
    segmentOf: (/** @type {number} */ face) => Math.floor(face / 10),
    faceOf: (/** @type {number} */ segment) => 10 * segment,
    hitAt: (/** @type {{ x: number }} */ place) => {
      const face = view.faceAt(place);
      return face === null ? null : { face, part: view.partOf(face), segment: view.segmentOf(face) };
    },
    lookAt: (/** @type {number} */ face) => view.looked.push(face),
    lookFrom: (/** @type {string} */ from) => view.looked.push(from),
    setLook: (/** @type {object} */ look) => Object.assign(view.look, look),
  });
  const segments = /** @type {any} */ ({
    ...{ level, count: 9, names: {}, offcut: null, sketch: null, nReads: 0 },
    pending: { operations: [] },
    titleOf: () => "Part",
    baseOf: (/** @type {number} */ face) => view.segmentOf(face),
    isTarget: (/** @type {number} */ face, /** @type {number} */ onto) =>
      view.segmentOf(face) !== view.segmentOf(onto),
    read: () => segments.nReads++,
  });
  /** @type {any[]} */
  const aimed = [];
  const cutPreview = {
    isLooking: false,
    aim: (/** @type {number | null} */ a, /** @type {number | null} */ b) => aimed.push([a, b]),
  };
  const around = /** @type {any} */ ({ model: fakeModel({ mode }), view, segments, root, ...dispatcher });
  around.signal = new AbortController().signal;
  const hand = createHand(around);
  const aim = createAim({ ...around, hand, cutPreview });
  dispatcher.said.length = 0;
  const press = (/** @type {any} */ type, /** @type {number} */ x, more = {}) =>
    hand.feed({ type, id: 1, x, y: 0, button: 0, hit: view.hitAt({ x }), ...more });
  return { hand, aim, view, segments, root, aimed, press, ...dispatcher };
}
