/** The steps that were taken, oldest first, and those that were undone: a click goes there. */

import { element, iconButton } from "./elements.js";

/** @typedef {{ n: number, title: string, time: number, problem: string }} Step  n: edits that are done after it */

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when it closes
 */
export function createHistory(send, leave) {
  const close = () => {
    send({ kind: "set", name: "history_shown", value: false });
    leave();
  };
  const steps = element("ol", { class: "sw-steps" });
  const shut = iconButton("close", "Close history", "U");
  shut.onclick = close;
  const card = element("section", { class: "sw-history", "aria-label": "History", hidden: "" }, [
    element("div", { class: "sw-history-head" }, [element("b", {}, ["History"]), shut]),
    steps,
  ]);
  let signature = "";

  card.onkeydown = (event) => {
    const buttons = [...steps.querySelectorAll("button")];
    const at = buttons.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    const moves = /** @type {Record<string, number>} */ ({
      ArrowUp: at - 1,
      ArrowDown: at + 1,
      Home: 0,
      End: 1e9,
    });
    if (event.key === "Escape") close();
    else if (at >= 0 && event.key in moves)
      buttons[Math.max(0, Math.min(buttons.length - 1, moves[event.key]))].focus();
    else return;
    event.preventDefault();
    event.stopPropagation();
  };

  return {
    element: card,
    get isShown() {
      return !card.hidden;
    },

    /** @param {boolean} isShown @param {Step[]} history @param {number} nDone  edits that are done */
    update(isShown, history, nDone) {
      card.hidden = !isShown;
      const next = JSON.stringify([history, nDone]);
      if (!isShown || next === signature) return;
      signature = next;
      const hadFocus = steps.contains(document.activeElement);
      const first = history.length > 0 ? history[0].n - 1 : 0;
      const start = first === 0 ? "As segmented" : `${first} earlier steps`;
      const rows = [{ n: first, title: start, time: 0, problem: "" }, ...history];
      steps.replaceChildren(
        ...rows.map(({ n, title, time, problem }) => {
          const isNow = n === nDone;
          const button = element("button", { class: "sw-step", type: "button" }, [
            element("span", { class: "sw-step-title" }, [title]),
            element("time", { class: "sw-step-time" }, [time ? clock(time) : ""]),
            ...(problem
              ? [element("span", { class: "sw-step-problem" }, [`Does not apply: ${problem}`])]
              : []),
          ]);
          if (isNow) button.setAttribute("aria-current", "step");
          button.dataset.state = problem ? "lost" : n > nDone ? "undone" : "done";
          button.title = isNow ? "Here you are" : n > nDone ? "Redo up to here" : "Undo back to here";
          button.onclick = () => n !== nDone && send({ kind: "go_to", n });
          return element("li", {}, [button]);
        }),
      );
      const now = /** @type {HTMLElement | null} */ (steps.querySelector("[aria-current]"));
      if (now) steps.scrollTop = now.offsetTop - steps.clientHeight / 2;
      if (hadFocus) now?.focus({ preventScroll: true });
    },
  };
}

/** @param {number} time  seconds since 1970 */
function clock(time) {
  return new Date(1000 * time).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
}
