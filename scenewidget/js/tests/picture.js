/** A picture to point at, with a hand and an aim on it, for tests in Node. */

import { createAim } from "../src/input/aim.js";
import { createHand } from "../src/input/hand.js";
import { fakeDispatcher, fakeModel, openPage, PageElement } from "./page.js";

openPage();

/** The surface of a strip of faces, each beside the next, with a crease before one of them. @param {number} n @param {number} crease */
function strip(n, crease) {
  const neighbors = new Int32Array(3 * n).fill(-1);
  const shut = new Uint8Array(n);
  for (let face = 1; face < n; face++) {
    neighbors[3 * face] = face - 1;
    neighbors[3 * (face - 1) + 1] = face;
  }
  shut[crease] = 1;
  shut[crease - 1] = 2;
  return { neighbors, shut, mark: new Uint32Array(n), last: 0 };
}

/** Triangles about the points (x, 0, 0), each leaning the other way than the next. @param {number} n */
function stripMesh(n) {
  const [vertices, faces] = [new Float32Array(9 * n), Uint32Array.from({ length: 3 * n }, (_, i) => i)];
  for (let x = 0; x < n; x++) {
    const tilt = x % 2 === 0 ? 0.1 : -0.1;
    vertices.set([x - 0.5, -0.5, -tilt, x + 0.5, -0.5, tilt, x, 1, 0], 9 * x);
  }
  return { vertices, faces, colors: null };
}

/** A picture 100 wide whose face at x is x; five faces a part, ten a segment. Hand and aim on it. */
export function fakePicture({ mode = "edit", level = "base" } = {}) {
  const dispatcher = fakeDispatcher();
  const root = /** @type {any} */ (new PageElement("div"));
  const view = /** @type {any} */ ({
    ...{ size: { width: 100, height: 50 }, isMoving: false, look: {}, partition: null, looked: [] },
    faceAt: (/** @type {{ x: number }} */ { x }) => (x < 90 ? x : null),
    pointAt: (/** @type {{ x: number }} */ { x }) => (x < 90 ? [x, 0, 0] : null),
    facesAround: (/** @type {{ x: number }} */ { x }, /** @type {number} */ radius) =>
      new Set(Array.from({ length: 90 }, (_, face) => face).filter((face) => Math.abs(face - x) <= radius)),
    placeOf: (/** @type {number[]} */ [x]) => ({ x, y: 0 }),
    sight: {
      widen() {},
      pixelAt: () => 0.01,
      placeOf: (/** @type {number} */ face) => ({ x: face, y: 0 }),
      awayFrom: (/** @type {number} */ face, /** @type {number[]} */ [x]) => (0.01 * (face - x)) ** 2,
      isSeen: () => true,
    },
    surface: strip(90, 45),
    mesh: stripMesh(90),
    facesWithin: (/** @type {Array<{ x: number }>} */ outline) => {
      const xs = outline.map(({ x }) => x);
      return new Set(
        Array.from({ length: 90 }, (_, x) => x).filter((x) => x >= Math.min(...xs) && x <= Math.max(...xs)),
      );
    },
    isDrawn: (/** @type {number} */ face) => face !== 13,
    pointBefore: (/** @type {{ x: number }} */ { x }) => [x, 0, 0],
    ownVector: (/** @type {number[]} */ [x, y, z]) => [z, x, y],
    before: new Set(),
    prepare: (/** @type {() => void} */ work) => {
      if (view.before.size === 0) {
        requestAnimationFrame(() => {
          for (const each of view.before) each();
          view.before.clear();
        });
      }
      view.before.add(work);
    },
    forget: (/** @type {() => void} */ work) => view.before.delete(work),
    prepareSurface: () => view.looked.push("surface"),
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
    groups: {},
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
