import assert from "node:assert/strict";
import { test } from "node:test";
import { cutFamily, Preview } from "../../src/labels/preview.js";
import { standIn } from "../../src/wire/saved_model.js";

const NONE = 0xffffffff;
globalThis.window = /** @type {any} */ (new EventTarget());
const { post, hear } = await import("../../src/wire/channel.js");

test("a cut takes so many merges back that its number of segments is left", () => {
  const merges = new Uint32Array([0, 1, 2, 3, 0, 2]);
  assert.deepEqual([...cutFamily(4, merges, 4)], [0, 1, 2, 3, NONE]);
  assert.deepEqual([...cutFamily(4, merges, 2)], [0, 0, 2, 2, NONE]);
  assert.deepEqual([...cutFamily(4, merges, 1)], [0, 0, 0, 0, NONE]);
});

test("a cut beyond the family is its end", () => {
  const merges = new Uint32Array([0, 1]);
  assert.deepEqual([...cutFamily(3, merges, 1)], [0, 0, 2, NONE]);
  assert.deepEqual([...cutFamily(3, merges, 9)], [0, 1, 2, NONE]);
});

test("only those on a channel hear it, until they stop", () => {
  const life = new AbortController();
  const heard = /** @type {unknown[]} */ ([]);
  hear(
    () => "a",
    (message) => heard.push(message),
    life.signal,
  );
  post("a", { n: 1 });
  post("b", { n: 2 });
  post("", { n: 3 });
  life.abort();
  post("a", { n: 4 });
  assert.deepEqual(heard, [{ n: 1 }]);
});

/** A model with a family of three pieces on four faces, the last without a piece. */
function modelWithFamily() {
  const arrays = {
    face_piece: new Uint16Array([0, 1, 2, 3]),
    family_merges: new Uint32Array([0, 1]),
    family_colors: new Uint8Array(9),
  };
  const state = Object.entries(arrays).map(([name, array]) => [
    `_${name}`,
    new DataView(array.buffer, 0, array.byteLength),
  ]);
  const headers = Object.entries(arrays).map(([name, array]) => {
    const dtype = array.constructor.name.replace("Array", "").toLowerCase();
    return [name, { dtype, shape: [array.length] }];
  });
  return standIn({ ...Object.fromEntries(state), _headers: Object.fromEntries(headers), _channel: "c" });
}

test("the slider's preview stays over results of earlier settings, and ends with its own", () => {
  const model = modelWithFamily();
  let changes = 0;
  const preview = new Preview(model, () => changes++, new AbortController().signal);
  assert.equal(preview.tables(), null);
  post("c", { kind: "granularity", n: 2, isResting: false });
  assert.deepEqual([...(preview.tables()?.atomSegment ?? [])], [0, 0, 2, NONE]);
  assert.deepEqual([...(preview.tables()?.faceAtom ?? [])], [0, 1, 2, 3]);
  model.set("revision", 1);
  assert.notEqual(preview.tables(), null);
  post("c", { kind: "granularity", n: 3, isResting: true });
  assert.deepEqual([...(preview.tables()?.atomSegment ?? [])], [0, 1, 2, NONE]);
  model.set("revision", 2);
  assert.equal(preview.tables(), null);
  assert.equal(changes, 3);
});

test("a computation that ends without a result ends the preview too", () => {
  const model = modelWithFamily();
  const preview = new Preview(model, () => {}, new AbortController().signal);
  post("c", { kind: "granularity", n: 2, isResting: true });
  model.set("busy", true);
  assert.notEqual(preview.tables(), null);
  model.set("busy", false);
  assert.equal(preview.tables(), null);
});

test("what the slider asks for ends where nothing comes of it, unless the slider still moves", () => {
  const model = modelWithFamily();
  const callbacks = /** @type {Array<(message: any) => void>} */ ([]);
  const watched = {
    ...model,
    on(/** @type {string} */ event, /** @type {any} */ callback) {
      if (event === "msg:custom") callbacks.push(callback);
      model.on(event, callback);
    },
  };
  const preview = new Preview(watched, () => {}, new AbortController().signal);
  const tell = (/** @type {any} */ message) => {
    for (const callback of callbacks) callback(message);
  };
  post("c", { kind: "granularity", n: 2, isResting: false });
  tell({ kind: "end_preview" });
  assert.notEqual(preview.tables(), null);
  post("c", { kind: "granularity", n: 2, isResting: true });
  tell({ kind: "look", from: "above" });
  assert.notEqual(preview.tables(), null);
  tell({ kind: "end_preview" });
  assert.equal(preview.tables(), null);
});
