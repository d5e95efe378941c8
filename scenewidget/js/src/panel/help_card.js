/** Keys and gestures, as far as they do something in the mode that one is in. */

import { AIM_HELP, helpSections } from "../input/keys.js";
import { element, iconButton } from "./elements.js";

/** @param {(isShown: boolean) => void} onShow  called when it has opened or closed */
export function createHelpCard(onShow) {
  const list = element("div", { class: "sw-keys" });
  const close = iconButton("close", "Close help", "?");
  const card = element(
    "div",
    { class: "sw-help", role: "dialog", "aria-label": "Keys and gestures", hidden: "" },
    [
      element("div", { class: "sw-help-head" }, [element("b", {}, ["Keys and gestures"]), close]),
      list,
      element("div", { class: "sw-aim-help" }, [AIM_HELP]),
    ],
  );
  const hasTouch = globalThis.matchMedia?.("(any-pointer: coarse)").matches ?? false;
  let listed = "";

  const show = (/** @type {boolean} */ isShown) => {
    card.hidden = !isShown;
    onShow(isShown);
    if (isShown) close.focus({ preventScroll: true });
  };
  close.onclick = () => show(false);

  return {
    element: card,
    show,
    isShown: () => !card.hidden,

    /** @param {Pick<import("./state.js").PanelState, "editable" | "mode">} state */
    update({ editable, mode }) {
      if (listed === `${editable} ${mode}`) return;
      listed = `${editable} ${mode}`;
      list.replaceChildren(
        ...helpSections({ editable, mode, hasTouch }).flatMap(({ title, rows }) => {
          const [first, ...rest] = rows.map(row);
          const head = element("div", { class: "sw-keys-title" }, [title]);
          return [element("div", { class: "sw-key-first" }, [head, first]), ...rest];
        }),
      );
    },
  };
}

/** @param {import("../input/keys.js").Row} row */
function row([keys, what]) {
  return element("div", { class: "sw-key" }, [element("b", {}, [keys]), element("span", {}, [what])]);
}
