import assert from "node:assert/strict";
import { test } from "node:test";
import { createNameForm } from "../../src/panel/name_form.js";
import { control, fakeDispatcher, fire, openPage } from "../page.js";

const body = openPage();

function fake() {
  const { send, take } = fakeDispatcher();
  const left = { n: 0 };
  const form = createNameForm(send, () => left.n++);
  body.append(/** @type {any} */ (form.element));
  form.offer(["chair", "table"], ["chair"]);
  form.ask({ face: 3, title: "Segment 1", name: "sofa", place: { x: 0, y: 0 } });
  return { form, take, left, input: control(form.element, "Name") };
}

test("a name is given without the spaces around it, and the focus goes back", () => {
  const { form, take, left, input } = fake();
  assert.deepEqual([form.isOpen(), input.value, document.activeElement], [true, "sofa", input]);
  input.value = " bed ";
  fire(form.element, "submit");
  assert.deepEqual(take(), [{ kind: "name", face: 3, name: "bed" }]);
  assert.deepEqual([form.isOpen(), left.n], [false, 1]);
});

test("the same name is none, nor is one that is called off", () => {
  const { form, take, input } = fake();
  fire(form.element, "submit");
  form.ask({ face: 3, title: "Segment 1", name: "sofa", place: { x: 0, y: 0 } });
  input.value = "bed";
  assert.equal(fire(input, "keydown", { key: "Escape" }).isStopped, true);
  assert.deepEqual([form.isOpen(), take()], [false, []]);
});

test("names with keys have buttons", () => {
  const { form, take } = fake();
  control(form.element, "4 chair").click();
  assert.deepEqual(take(), [{ kind: "name", face: 3, name: "chair" }]);
});
