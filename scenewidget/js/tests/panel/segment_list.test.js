import assert from "node:assert/strict";
import { test } from "node:test";
import { NONE } from "../../src/labels/partition.js";
import { createSegmentList } from "../../src/panel/segment_list.js";
import { control, fakeDispatcher, fire, openPage } from "../page.js";

const body = openPage();
const row = (/** @type {number} */ segment, changes = {}) => ({
  ...{ segment, name: "", color: "red", faces: 10 * (segment + 1), area: segment + 1, confidence: 0.5 },
  ...{ whole: /** @type {number | null} */ (null), hidden: /** @type {const} */ ("none"), ...changes },
});

function fake(rows = [row(0), row(1, { name: "chair" }), row(2)]) {
  const { send, take } = fakeDispatcher();
  const list = createSegmentList(send, () => {});
  body.append(/** @type {any} */ (list.element));
  list.show(true);
  list.update(rows);
  const lines = () => /** @type {any} */ (list.element).querySelector("tbody").rows;
  return {
    list,
    take,
    lines,
    order: () => lines().map((/** @type {any} */ line) => Number(line.dataset.segment)),
  };
}

test("largest first; a column sorts, and again the other way", () => {
  const { list, order } = fake();
  assert.deepEqual(order(), [2, 1, 0]);
  control(list.element, "Faces").click();
  assert.deepEqual(order(), [2, 1, 0]);
  control(list.element, "Faces").click();
  assert.deepEqual(order(), [0, 1, 2]);
});

test("areas of what is small are told to the square centimetre", () => {
  const area = (/** @type {number[]} */ areas) =>
    fake(areas.map((value, i) => row(i, { area: value }))).lines()[1].textContent;
  assert.match(area([0.1904, 0.0012]), /0\.0012/);
  assert.match(area([12, 0.0012]), /200\.000\.50$/); // 20 faces, 0.00, 0.50
});

test("pointing, choosing and hiding say so", () => {
  const { lines, take } = fake();
  const [first] = lines();
  const [eye, name] = first.querySelectorAll("button");
  fire(name, "pointerover");
  name.click();
  eye.click();
  assert.deepEqual(take(), [
    { kind: "listed", segment: 2 },
    { kind: "choose_segment", segment: 2 },
    { kind: "act_on_segment", what: "hide", segment: 2 },
  ]);
});

test("of all rows one is a stop of Tab, arrows go on, letters act on it", () => {
  const { lines, take } = fake();
  const stops = () => lines().map((/** @type {any} */ line) => line.querySelector(".sw-row-name").tabIndex);
  assert.deepEqual(stops(), [0, -1, -1]);
  const [first] = lines();
  first.querySelector(".sw-row-name").focus();
  fire(document.activeElement, "focusin");
  fire(document.activeElement, "keydown", { key: "ArrowDown" });
  fire(document.activeElement, "focusin");
  assert.deepEqual(stops(), [-1, 0, -1]);
  fire(document.activeElement, "keydown", { key: "f" });
  assert.deepEqual(take("act_on_segment"), [{ kind: "act_on_segment", what: "frame", segment: 1 }]);
});

test("parts stand under their whole and say so", () => {
  const { order, lines } = fake([row(0, { whole: 1 }), row(1, { name: "sofa" }), row(2)]);
  assert.deepEqual(order(), [2, 1, 0]);
  const part = lines()[2];
  assert.ok(part.classList.contains("sw-part"));
  assert.match(part.querySelector(".sw-row-name").title, /part of Segment 1 \(sofa\)$/);
});

test("rows are changed in place, and hidden ones counted", () => {
  const { list, lines } = fake();
  const before = lines()[0];
  list.update([row(0, { hidden: "all" }), row(2), row(NONE)]);
  assert.equal(lines()[0], before);
  assert.match(list.element.textContent ?? "", /2 · 1 hidden/);
});

test("what is pointed at in the picture is marked", () => {
  const { list, lines } = fake();
  list.mark(1);
  assert.deepEqual(
    lines().map((/** @type {any} */ line) => line.classList.contains("sw-marked")),
    [false, true, false],
  );
  list.mark(null);
  assert.equal(lines()[1].classList.contains("sw-marked"), false);
});
