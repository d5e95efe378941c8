/** The map of the house holds: who may know whom, and nobody knows somebody who knows him. */

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { test } from "node:test";

const SOURCE = join(import.meta.dirname, "..", "src");

/** Each may import from itself and from those before it. `index.js` puts everything together. */
const LAYERS = ["wire", "labels", "scene", "input", "panel"];
/** The settings beside a view are another page element: they share these with it. */
const SHARED_WITH_CONTROLS = [
  "controls",
  "wire",
  "panel/elements.js",
  "panel/number_input.js",
  "panel/theme.js",
];

/** The queue of scans above a view is a third. */
const SHARED_WITH_WORKBENCH = ["workbench", "wire", "panel/elements.js", "panel/theme.js"];

/** Imports of each file, those of types included. */
const imports = new Map(
  readdirSync(SOURCE, { recursive: true, encoding: "utf8" })
    .filter((file) => file.endsWith(".js"))
    .map((file) => [file.replaceAll("\\", "/"), importsOf(join(SOURCE, file))]),
);

/** @param {string} path */
function importsOf(path) {
  const text = readFileSync(path, "utf8");
  const names = [...text.matchAll(/(?:from|import)[ (]"(\.[^"]+)"/g)].map(([, name]) => name);
  return new Set(names.map((name) => relative(SOURCE, join(dirname(path), name)).replaceAll("\\", "/")));
}

const folderOf = (/** @type {string} */ file) => (file.includes("/") ? file.split("/")[0] : "");

test("every file is in a folder that has its place, and imports files that are there", () => {
  for (const [file, names] of imports) {
    assert.ok(["", ...LAYERS, "controls", "workbench"].includes(folderOf(file)), file);
    for (const name of names) assert.ok(imports.has(name), `${file} imports ${name}`);
  }
  assert.deepEqual(
    [...imports.keys()].filter((file) => folderOf(file) === ""),
    ["index.js"],
  );
});

test("a folder knows those below it alone", () => {
  for (const [file, names] of imports) {
    const layer = LAYERS.indexOf(folderOf(file));
    if (layer < 0) continue;
    for (const name of names) {
      const other = LAYERS.indexOf(folderOf(name));
      assert.ok(other >= 0 && other <= layer, `${file} imports ${name}`);
    }
  }
});

test("settings and queue share with a view what they need alone", () => {
  for (const [file, names] of imports) {
    const allowed = { controls: SHARED_WITH_CONTROLS, workbench: SHARED_WITH_WORKBENCH }[folderOf(file)];
    if (!allowed) continue;
    for (const name of names) {
      const isShared = allowed.some((shared) => name === shared || folderOf(name) === shared);
      assert.ok(isShared, `${file} imports ${name}`);
    }
  }
});

test("no file imports itself, by whatever way round", () => {
  /** @param {string} file @param {string[]} way */
  const follow = (file, way) => {
    assert.ok(!way.includes(file), [...way, file].join(" → "));
    for (const name of imports.get(file) ?? []) if (!done.has(name)) follow(name, [...way, file]);
    done.add(file);
  };
  const done = new Set();
  for (const file of imports.keys()) follow(file, []);
});

test("the page is touched by input and panel alone, WebGL by the renderer alone", () => {
  for (const file of imports.keys()) {
    const text = readFileSync(join(SOURCE, file), "utf8");
    if (["wire", "labels", "scene"].includes(folderOf(file))) assert.doesNotMatch(text, /\bdocument\./, file);
    if (file !== "scene/renderer.js") assert.doesNotMatch(text, /"three"/, file);
  }
});
