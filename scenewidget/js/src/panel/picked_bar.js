/** What can be done with the picked part or with what the brush has gathered; else how a tool goes. */

import { element, iconButton, textButton } from "./elements.js";

/** @type {Array<[string, import("../input/keys.js").PartAction, string]>} */
const ACTIONS = [
  ["Split", "split", "Split this part off (S)"],
  ["Name", "name", "Name this segment (N)"],
  ["Ungroup", "ungroup", "No longer a part; of a whole, let go of its parts"],
  ["Hide", "hide", "Hide this segment (H)"],
  ["Isolate", "isolate", "Hide all other segments (I)"],
  ["Frame", "frame", "Fit this segment into the view (F)"],
];

const UNGROUP = ACTIONS.findIndex(([, what]) => what === "ungroup");

/** @type {Array<[import("../labels/prediction.js").Refinement, Parameters<typeof iconButton>[0], string]>} */
const REFINEMENTS = [
  ["grow", "grow", "Grow by a ring of faces"],
  ["shrink", "shrink", "Shrink by a ring of faces"],
  ["fill_holes", "fillHoles", "Fill holes"],
  ["smooth_border", "smooth", "Smooth the border"],
];

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when the bar goes
 */
export function createPickedBar(send, leave) {
  const text = element("span", { class: "sw-picked-text", role: "status" });
  const letGo = iconButton("close", "Let go", "Esc");
  const finish = textButton("Merge them", "Merge what is gathered (Shift + Enter)");
  const group = textButton("Group them", "Parts of one thing, which stay segments");
  const buttons = ACTIONS.map(([name, what, title]) => {
    const button = textButton(name, title);
    button.onclick = () => send({ kind: "act_on_picked", what });
    return button;
  });
  const refinements = REFINEMENTS.map(([how, icon, name]) => {
    const button = iconButton(icon, name, "");
    button.title = name;
    button.onclick = () => send({ kind: "refine", how });
    button.onpointerenter = button.onfocus = () => send({ kind: "refine_preview", how });
    button.onpointerleave = button.onblur = () => send({ kind: "refine_preview", how: null });
    return button;
  });
  letGo.onclick = () => send({ kind: "back" });
  finish.onclick = () => send({ kind: "finish" });
  group.onclick = () => send({ kind: "group" });
  const bar = element(
    "div",
    { class: "sw-picked", role: "toolbar", "aria-label": "Picked part", hidden: "" },
    [text, ...buttons, ...refinements, finish, group, letGo],
  );
  return {
    element: bar,

    /** @param {{ text: string | null, of: "part" | "stroke" | "hint", isGrouped?: boolean }} hint */
    show({ text: words, of, isGrouped }) {
      for (const button of [...buttons, ...refinements]) button.hidden = of !== "part";
      if (!isGrouped) buttons[UNGROUP].hidden = true;
      finish.hidden = group.hidden = of !== "stroke";
      bar.dataset.kind = of;
      if (text.textContent !== (words ?? "")) text.textContent = words ?? "";
      if (words === null && bar.contains(document.activeElement)) leave();
      bar.hidden = words === null;
    },
  };
}
