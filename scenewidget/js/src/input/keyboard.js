/** Key presses on a view: finds what each means and has it done. */

import { WHOLE } from "../scene/section.js";
import { command, wayOf } from "./keys.js";
import { createWalking } from "./strides.js";

/**
 * @param {object} around
 * @param {import("../wire/wire.js").Model} around.model
 * @param {import("../scene/viewer.js").Viewer} around.view
 * @param {ReturnType<typeof import("../panel/panel.js").createPanel>} around.panel
 * @param {ReturnType<typeof import("./pointer.js").createPointing>} around.pointing
 * @param {ReturnType<typeof import("./edit_commands.js").createEditing>} around.editing
 * @param {AbortSignal} around.signal
 */
export function listenToKeys({ model, view, panel, pointing, editing, signal }) {
  const { root } = panel;

  /** @param {string} name @param {unknown} value */
  const set = (name, value) => {
    model.set(name, value);
    model.save_changes();
  };

  /** @param {KeyboardEvent} event */
  const onKey = (event) => {
    const target = event.target instanceof HTMLElement ? event.target : root;
    if (target.matches("select, input") && event.key !== "Escape") return;
    if (target.matches("button") && (event.key === "Enter" || event.key === " ")) return;
    const ordered = command(event, model.get("mode"), view.isInside);
    if (!ordered || (ordered.kind === "save" && !model.get("editable"))) return;
    event.preventDefault();
    event.stopPropagation();
    pointing.showAim(target === root);
    obey(ordered);
  };

  /** @param {import("./keys.js").Command} ordered */
  const obey = (ordered) => {
    const place = pointing.aimed();
    const face = place && view.faceAt(place);
    const picked = pointing.picked();
    switch (ordered.kind) {
      case "orbit":
      case "pan":
        view.apply(ordered);
        break;
      case "zoom":
        view.apply({ ...ordered, x: view.size.width / 2, y: view.size.height / 2 });
        break;
      case "walk":
        walking.start(ordered.way);
        break;
      case "look":
        view.lookFrom(ordered.from);
        break;
      case "level":
        if (ordered.index < model.get("levels").length) set("level", model.get("levels")[ordered.index]);
        break;
      case "quick_name": {
        const name = model.get("quick_names")[ordered.index];
        const aim = face ?? picked?.face;
        if (name && aim !== undefined) editing.nameQuickly(aim, name);
        break;
      }
      case "toggle":
        if (ordered.what === "help") panel.showHelp(!panel.isHelpShown());
        else if (ordered.what === "inside") view.goInside(!view.isInside);
        else if (ordered.what === "section") panel.section.show(!panel.section.isShown());
        else if (ordered.what === "ceiling") set("section", view.isCut ? WHOLE : view.openedAbove);
        else if (ordered.what !== "mode") set(ordered.what, !model.get(ordered.what));
        else if (model.get("editable")) set("mode", model.get("mode") === "edit" ? "navigate" : "edit");
        break;
      case "escape":
        if (panel.isHelpShown()) panel.showHelp(false);
        else if (pointing.back()) break;
        else if (panel.section.isShown()) panel.section.show(false);
        else if (model.get("history_shown")) set("history_shown", false);
        break;
      case "tool":
        pointing.setTool(ordered.tool);
        break;
      case "finish":
        pointing.finish();
        break;
      case "choose":
        pointing.choose();
        break;
      case "part":
        if (face !== null) editing.act(ordered.what, face, place);
        else if (picked) editing.act(ordered.what, picked.face, place);
        else if (ordered.what === "frame") view.lookFrom("here");
        break;
      case "show_all":
        editing.hide(null);
        break;
      case "save":
        model.send({ kind: "save" });
        break;
      default:
        editing.walk(ordered.kind);
    }
  };
  const walking = createWalking(view);
  root.addEventListener("keydown", onKey, { signal });
  root.addEventListener("keyup", (event) => walking.stop(wayOf(event.key)), { signal });
  root.addEventListener("focusout", () => walking.stop(), { signal });
  signal.addEventListener("abort", () => walking.stop());
}
