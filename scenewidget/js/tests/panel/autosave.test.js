import assert from "node:assert/strict";
import { test } from "node:test";
import { createAutosave } from "../../src/panel/autosave.js";
import { control, fakeDispatcher, openPage } from "../page.js";

openPage();

const state = { saveState: /** @type {const} */ ("saved"), saveNote: "room.swproj", pending: 0, notices: [] };

function fake() {
  const { send, take } = fakeDispatcher();
  const left = { n: 0 };
  return { autosave: createAutosave(send, () => left.n++), take, left };
}

test("nothing is saved while an edit is on its way", () => {
  const { autosave } = fake();
  autosave.update(state);
  assert.deepEqual([autosave.word.textContent, autosave.word.dataset.state], ["Saved", "saved"]);
  autosave.update({ ...state, pending: 1 });
  assert.equal(autosave.word.textContent, "Saving");
  autosave.update({ ...state, saveState: "failed", pending: 1 });
  assert.equal(autosave.word.textContent, "Can't save");
});

test("a bar answers with the button that was pressed, and gives the focus back", () => {
  const { autosave, take, left } = fake();
  const notice = { key: "found", text: "Edits were found", actions: [["Open", "open"]] };
  autosave.update({ ...state, notices: /** @type {any} */ ([notice]) });
  control(autosave.bars, "Open").click();
  assert.deepEqual(take(), [{ kind: "answer", notice: "found", action: "open" }]);
  assert.equal(left.n, 1);
  autosave.update(state);
  assert.equal(autosave.bars.textContent, "");
});

test("its button saves, and tells where", () => {
  const { autosave, take } = fake();
  autosave.update(state);
  autosave.button.click();
  assert.deepEqual(take(), [{ kind: "save" }]);
  assert.match(autosave.button.title, /room\.swproj/);
});
