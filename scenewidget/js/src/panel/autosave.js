/** How it stands with the edits' file: a button, a word beside it, and bars that offer something. */

import { element, iconButton, textButton } from "./elements.js";

/** @typedef {"" | "unsaved" | "saving" | "saved" | "failed" | "read-only"} SaveState */

/** @type {Record<SaveState, string>} */
const WORDS = {
  "": "",
  unsaved: "Not saved",
  saving: "Saving",
  saved: "Saved",
  failed: "Can't save",
  "read-only": "Read-only",
};

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when a button of a bar was pressed
 */
export function createAutosave(send, leave) {
  const button = iconButton("save", "Save", "Ctrl + S");
  const word = element("span", { class: "sw-saved", role: "status" });
  const bars = element("div", { class: "sw-notices" });
  button.onclick = () => send({ kind: "save" });
  let shown = "";

  return {
    button,
    word,
    bars,

    /**
     * @param {object} state
     * @param {SaveState} state.saveState
     * @param {string} state.saveNote
     * @param {number} state.pending  edits that Python hasn't answered
     * @param {import("./notices.js").Notice[]} state.notices
     */
    update({ saveState, saveNote, pending, notices }) {
      const told = saveState === "saved" && pending > 0 ? "saving" : saveState;
      if (word.textContent !== WORDS[told]) word.textContent = WORDS[told];
      word.dataset.state = told;
      word.title = saveNote;
      button.title = `Save${saveNote && `: ${saveNote}`} (Ctrl + S)`;
      const signature = JSON.stringify(notices);
      if (signature === shown) return;
      shown = signature;
      bars.replaceChildren(
        ...notices.map(({ key, text, actions, asks }) =>
          element("div", { class: "sw-notice", "data-key": key, ...roleOf(asks) }, [
            element("span", { class: "sw-notice-text" }, [text]),
            ...actions.map(([label, action]) => {
              const choice = textButton(label);
              choice.onclick = () => {
                send({ kind: "answer", notice: key, action });
                leave();
              };
              return choice;
            }),
          ]),
        ),
      );
    },
  };
}

/**
 * What is amiss interrupts whoever listens; a question waits.
 * @param {string} [asks]
 * @returns {Record<string, string>}
 */
function roleOf(asks) {
  return asks ? { role: "group", "aria-label": asks } : { role: "alert" };
}
