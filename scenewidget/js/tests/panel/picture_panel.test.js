import assert from "node:assert/strict";
import { test } from "node:test";
import { createPicturePanel } from "../../src/panel/picture_panel.js";
import { control, fakeDispatcher, fire, openPage, PageElement } from "../page.js";

const body = openPage();
/** @type {any[]} */
const sheets = [];
Object.assign(PageElement.prototype, {
  getContext() {
    return { fillRect() {}, drawImage: (/** @type {unknown} */ picture) => sheets.push([this, picture]) };
  },
  toBlob: (/** @type {(blob: unknown) => void} */ done) => done(new Blob(["png"])),
});

function fake() {
  const { send, take, handlers } = fakeDispatcher();
  const left = { n: 0 };
  const shown = { size: () => ({ width: 800.4, height: 420 }), theme: () => /** @type {const} */ ("dark") };
  const panel = createPicturePanel(send, () => left.n++, shown);
  body.append(/** @type {any} */ (panel.element));
  panel.show(true);
  sheets.length = 0;
  const named = (/** @type {string} */ name) => control(panel.element, name);
  const note = () => /** @type {any} */ (panel.element).querySelector(".sw-picture-note").textContent;
  return { panel, take, handlers, left, named, note };
}

test("it proposes the size on the page, twice as fine, and tells what that makes", () => {
  const { named, note } = fake();
  assert.deepEqual([named("Width in pixels").value, named("Height in pixels").value], ["800", "420"]);
  assert.equal(note(), "1600 × 840 pixels");
  named("Width in pixels").value = "1 000";
  fire(named("Width in pixels"), "input");
  assert.equal(note(), "2000 × 840 pixels");
  named("Width in pixels").value = "wide";
  fire(named("Width in pixels"), "input");
  assert.equal(named("Save PNG").disabled, true);
});

test("the picture is drawn at that size and becomes a file", async () => {
  const { named, handlers, take, note } = fake();
  handlers.draw = (/** @type {any} */ { take: copy }) => copy("picture");
  named("Save PNG").click();
  await new Promise(setImmediate);
  const [{ width, height, scale }] = take("draw");
  assert.deepEqual([width, height, scale], [800, 420, 2]);
  const [[sheet, picture]] = sheets;
  assert.deepEqual([sheet.width, sheet.height, picture], [1600, 840, "picture"]);
  assert.match(note(), /^Saved/);
});

test("what can't be drawn is told of", async () => {
  const { named, handlers, note } = fake();
  handlers.draw = () => {
    throw new RangeError("too large");
  };
  named("Save PNG").click();
  await new Promise(setImmediate);
  assert.equal(note(), "too large");
});

test("the legend is offered where there is one, digits stay in their boxes, Escape closes", () => {
  const { panel, named, left } = fake();
  panel.update({ legend: null });
  assert.equal(named("With the legend").parentElement?.hidden ?? true, true);
  assert.equal(fire(named("Width in pixels"), "keydown", { key: "2" }).isStopped, true);
  assert.equal(fire(named("Save PNG"), "keydown", { key: "o" }).isStopped, false);
  fire(named("Save PNG"), "keydown", { key: "Escape" });
  assert.deepEqual([panel.isShown(), left.n], [false, 1]);
});
