/** Wishes that are pieces of the model's state, or that Python fulfils without further ado. */

/** @typedef {import("./messages.js").Around} Around */

const TRAITS = ["outlines", "back_faces", "boxes", "segment_list", "history_shown"]; // that are on or off

/** @param {Pick<Around, "model" | "on">} around */
export function createStateCommands({ model, on }) {
  const set = (/** @type {string} */ name, /** @type {unknown} */ value) => {
    model.set(name, value);
    model.save_changes();
  };
  on({
    set: ({ name, value }) => set(name, value),
    toggle({ what }) {
      if (TRAITS.includes(what)) set(what, !model.get(what));
      else if (what === "mode" && model.get("editable"))
        set("mode", model.get("mode") === "edit" ? "navigate" : "edit");
    },
    level({ index }) {
      if (index < model.get("levels").length) set("level", model.get("levels")[index]);
    },
    cancel: () => model.send({ kind: "cancel" }),
    save: () => model.send({ kind: "save" }),
  });
}
