import assert from "node:assert/strict";
import { test } from "node:test";
import { createSectionPanel } from "../../src/panel/section_panel.js";
import { WHOLE } from "../../src/scene/section.js";
import { control, fakeDispatcher, fire, openPage } from "../page.js";

const body = openPage();

function fake() {
  const { send, take } = fakeDispatcher();
  const left = { n: 0 };
  const panel = createSectionPanel(send, () => left.n++);
  body.append(/** @type {any} */ (panel.element));
  panel.update(WHOLE, [4, 3, 2]);
  return { panel, take, left, slider: (/** @type {string} */ name) => control(panel.element, name) };
}

test("a thumb moves its end, never past the other", () => {
  const { take, slider } = fake();
  slider("Height to").value = "0.75";
  fire(slider("Height to"), "input");
  slider("Width from").value = "1";
  fire(slider("Width from"), "input");
  const [height, width] = take("set").map(({ value }) => value);
  assert.deepEqual(height, [
    [0, 1],
    [0, 1],
    [0, 0.75],
  ]);
  assert.deepEqual(width[1], [0.98, 1]);
});

test("lengths are told in metres", () => {
  const { panel, slider } = fake();
  panel.update(
    [
      [0, 1],
      [0, 1],
      [0.25, 0.5],
    ],
    [4, 3, 2],
  );
  assert.equal(slider("Height from").getAttribute("aria-valuetext"), "0.5 m");
  assert.match(panel.element.textContent ?? "", /0\.5 – 1\.0 m/);
  assert.equal(slider("Show the whole scan").disabled, false);
  panel.update(
    [
      [0, 1],
      [0, 1],
      [0, 0.5],
    ],
    [0.5, 3, 2],
  ); // a table is told in centimetres
  assert.match(panel.element.textContent ?? "", /0\.00 – 0\.50 m/);
});

test("the ceiling goes, everything comes back, and it closes with Escape", () => {
  const { panel, take, left, slider } = fake();
  panel.show(true);
  assert.equal(document.activeElement, slider("Height to"));
  slider("Cut the ceiling off").click();
  panel.update(
    [
      [0, 1],
      [0, 1],
      [0, 0.5],
    ],
    [4, 3, 2],
  );
  slider("Show the whole scan").click();
  assert.deepEqual(take(), [{ kind: "cut_ceiling" }, { kind: "set", name: "section", value: WHOLE }]);
  fire(slider("Height to"), "keydown", { key: "Escape" });
  assert.deepEqual([panel.isShown(), left.n], [false, 1]);
});
