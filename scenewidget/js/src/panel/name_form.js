/** The little form in which a segment gets its name. */

import { QUICK_KEYS } from "../input/keys.js";
import { element, textButton } from "./elements.js";

/** @typedef {import("../input/gestures.js").Place} Place */

const MOST_CHARACTERS = "200";
let count = 0;

/**
 * @param {import("../input/messages.js").Send} send
 * @param {() => void} leave  puts the focus back when it closes
 */
export function createNameForm(send, leave) {
  const id = `sw-vocabulary-${++count}`;
  const words = element("datalist", { id });
  const input = element("input", {
    class: "sw-name",
    list: id,
    maxlength: MOST_CHARACTERS,
    autocomplete: "off",
    spellcheck: "false",
    "aria-label": "Name",
    placeholder: "Name",
  });
  const title = element("span", { class: "sw-naming-title" });
  const ok = textButton("OK", "Give this name; an empty one takes the name away (Enter)");
  ok.type = "submit";
  const cancel = textButton("Cancel", "Leave it as it is (Esc)");
  const quick = element("div", { class: "sw-quick", role: "group", "aria-label": "Names with keys" });
  const form = element(
    "form",
    { class: "sw-naming", role: "dialog", "aria-label": "Name a segment", hidden: "" },
    [...[title, input, ok, cancel, quick, words]],
  );
  /** What is named, and how it is called so far. */
  let asked = { face: -1, name: "" };

  const close = () => {
    if (form.hidden) return;
    form.hidden = true;
    leave();
  };
  const give = (/** @type {string} */ name) => {
    close();
    if (name !== asked.name) send({ kind: "name", face: asked.face, name });
  };
  form.onsubmit = (event) => {
    event.preventDefault();
    give(input.value.trim());
  };
  cancel.onclick = close;
  form.onkeydown = (event) => {
    event.stopPropagation();
    if (event.key === "Escape") close();
  };
  return {
    element: form,
    close,
    isOpen: () => !form.hidden,

    /** Words to choose from. @param {string[]} vocabulary @param {string[]} quickNames  those that have keys */
    offer(vocabulary, quickNames) {
      const signature = JSON.stringify([vocabulary, quickNames]);
      if (words.dataset.words === signature) return;
      words.dataset.words = signature;
      quick.replaceChildren(
        ...quickNames.slice(0, QUICK_KEYS.length).map((name, i) => {
          const button = textButton(name, `${name}: key ${QUICK_KEYS[i]}, without this form`);
          button.prepend(element("kbd", {}, [QUICK_KEYS[i]]), " ");
          button.onclick = () => give(name);
          return button;
        }),
      );
      words.replaceChildren(...vocabulary.map((word) => element("option", { value: word })));
    },

    /**
     * @param {object} question
     * @param {number} question.face
     * @param {string} question.title  of what is named
     * @param {string} question.name  that it has
     * @param {Place} question.place
     */
    ask({ face, title: what, name, place }) {
      asked = { face, name };
      title.textContent = what;
      input.value = name;
      form.hidden = false;
      const { clientWidth, clientHeight } = /** @type {HTMLElement} */ (form.parentElement);
      const left = Math.min(place.x + 10, clientWidth - form.offsetWidth - 8);
      const top = Math.min(place.y + 10, clientHeight - form.offsetHeight - 8);
      form.style.left = `${Math.max(8, left)}px`;
      form.style.top = `${Math.max(8, top)}px`;
      input.focus({ preventScroll: true });
      input.select();
    },
  };
}
