/** The settings beside a view: what they are, what they are now, and what a person does with them. */

import { element } from "../panel/elements.js";
import { watchTheme } from "../panel/theme.js";
import { post } from "../wire/channel.js";
import { watchConnection } from "../wire/connection.js";
import { listen } from "../wire/listen.js";
import { createBar } from "./bar.js";
import { createField } from "./fields.js";

/** @typedef {import("../wire/wire.js").Model} Model */

const GONE = "The kernel is gone: settings change nothing. Run the cell again.";
const MOVE_MS = 80; // between two previews that are asked for
const STATE = [
  ...["values", "k_bounds", "idle", "problems", "changed", "family", "preset", "presets", "code"],
  ...["can_rerun", "can_suggest", "scores", "revision"],
];

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @returns {() => void}  undoes everything
 */
function render({ model, el }) {
  const life = new AbortController();
  const root = element("div", { class: "swc", role: "group", "aria-label": "Settings" });
  const stopTheme = watchTheme(el, (isDark) => {
    root.dataset.theme = isDark ? "dark" : "light";
  });
  let moveTimer = 0;
  let lastMove = -Infinity;

  const actions = {
    /** A thumb moves: show what would come. @param {string} name @param {unknown} value */
    move(name, value) {
      root.dataset.moving = name;
      if (name === "granularity") {
        post(model.get("_channel"), { kind: "granularity", n: value, isResting: false });
        return;
      }
      clearTimeout(moveTimer);
      const send = () => {
        lastMove = performance.now();
        model.send({ kind: "move", name, value });
      };
      moveTimer = window.setTimeout(send, Math.max(0, lastMove + MOVE_MS - performance.now()));
    },

    /** A person is done with it. @param {string} name @param {unknown} value */
    set(name, value) {
      clearTimeout(moveTimer);
      root.dataset.moving = "";
      if (name === "granularity") {
        post(model.get("_channel"), { kind: "granularity", n: value, isResting: true });
      }
      model.send({ kind: "set", name, value });
    },

    /** A person has thought better of it. @param {string} name */
    leave(name) {
      clearTimeout(moveTimer);
      root.dataset.moving = "";
      if (name === "granularity")
        post(model.get("_channel"), { kind: "granularity", n: null, isResting: true });
      else model.send({ kind: "leave" });
      update();
    },

    /** @param {"next" | "names"} what */
    suggest: (what) => post(model.get("_channel"), { kind: "suggest", what }),

    /** @param {Record<string, unknown>} message */
    send: (message) => model.send(message),
  };

  /** @type {Array<ReturnType<typeof createField>>} */
  const fields = [];
  const main = element("div", { class: "swc-rows" });
  const bar = createBar(actions);
  const fold = element("details", { class: "swc-fold" }, [
    element("summary", {}, ["Advanced", element("span", { class: "swc-count" })]),
  ]);
  const groups = new Map([["", main]]);
  for (const description of model.get("fields")) {
    const field = createField(description, actions);
    fields.push(field);
    if (!groups.has(description.group)) {
      const rows = element("div", { class: "swc-rows" });
      groups.set(description.group, rows);
      const title = element("div", { class: "swc-group", role: "heading", "aria-level": "4" }, [
        description.group,
      ]);
      fold.append(element("section", { "aria-label": description.group }, [title, rows]));
    }
    groups.get(description.group)?.append(field.element);
  }
  const gone = element("p", { class: "swc-gone", role: "status", hidden: "" }, [GONE]);
  const all = element("fieldset", { class: "swc-all" }, [bar.scores, main, fold, bar.element]);
  root.append(gone, all);
  el.append(root);
  const connection = watchConnection(model, el, showConnection, life.signal);

  function showConnection() {
    const isLive = connection.isLive();
    root.dataset.live = String(isLive);
    gone.hidden = isLive;
    all.disabled = !isLive;
  }

  function update() {
    const changed = new Set(model.get("changed"));
    for (const field of fields) {
      const { name } = field;
      field.update({
        value: model.get("values")[name],
        bounds: name === "k_range" ? model.get("k_bounds") : null,
        family: name === "granularity" ? model.get("family") : null,
        idle: model.get("idle")[name] ?? "",
        problem: model.get("problems")[name] ?? "",
        isChanged: changed.has(name),
      });
    }
    const nFolded = fields.filter(({ name, group }) => group && changed.has(name)).length;
    const count = fold.querySelector(".swc-count");
    if (count) count.textContent = nFolded ? `${nFolded} changed` : "";
    bar.update({
      preset: model.get("preset"),
      presets: model.get("presets"),
      nChanged: changed.size,
      code: model.get("code"),
      canRerun: model.get("can_rerun"),
      canSuggest: model.get("can_suggest"),
      scores: model.get("scores"),
    });
    root.dataset.revision = String(model.get("revision"));
  }

  listen(model, { state: STATE }, update, life.signal);
  update();
  showConnection();
  return () => {
    clearTimeout(moveTimer);
    life.abort();
    stopTheme();
    root.remove();
  };
}

export default { render };
