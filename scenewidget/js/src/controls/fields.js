/** One setting: its label, its input, why it has no effect now, what is wrong with it. */

import { element } from "../panel/elements.js";
import { createNumberInput, numberOf } from "../panel/number_input.js";

/**
 * @typedef {object} Description
 * @property {string} name
 * @property {string} label
 * @property {string} tip
 * @property {string} group  "" is always on view
 * @property {"slider" | "range" | "number" | "choice" | "check" | "list" | "family"} kind
 * @property {number} [low]
 * @property {number} [high]
 * @property {number} [step]
 * @property {Array<[string, string, string?]>} [choices]  value, text, why it can't be chosen
 * @property {string} [automatic]  text of a box that leaves the value to the program, and what it stands for
 * @property {unknown} [automaticValue]
 */

/**
 * @typedef {object} FieldState
 * @property {any} value
 * @property {[number, number] | null} bounds  of the k-range in force
 * @property {[number, number, number] | [] | null} family  fewest and most segments, and those of the result
 * @property {string} idle  why it has no effect
 * @property {string} problem
 * @property {boolean} isChanged  from the preset
 */

/**
 * @typedef {object} Actions
 * @property {(name: string, value: unknown) => void} move
 * @property {(name: string, value: unknown) => void} set
 * @property {(name: string) => void} leave
 */

/** @typedef {Actions & { refuse: (text: string) => void }} Typing  refuse: what isn't a number */

/** @typedef {{ element: HTMLElement, inputs: HTMLInputElement[] | HTMLSelectElement[], show: (state: FieldState) => void }} Input */

const KEY_MS = 350; // keys that follow each other faster are one movement
let nFields = 0;

/** @param {Description} description @param {Actions} actions */
export function createField(description, actions) {
  const { name, label, tip, group, kind } = description;
  const id = `swc-${++nFields}`;
  const makers = { slider, family: slider, range, number, choice, check, list };
  /** Text that was typed and is no number. */
  let refused = "";
  /** @type {FieldState | null} */
  let last = null;
  const refuse = (/** @type {string} */ text) => {
    if (text === refused) return;
    refused = text;
    if (last) update(last);
  };
  const input = makers[kind](description, { ...actions, refuse }, id);
  const why = element("div", { class: "swc-why", id: `${id}-why`, hidden: "" });
  const text = element("label", { class: "swc-label", for: id, title: tip }, [label]);
  const row = element("div", { class: `swc-row swc-${kind}`, "data-name": name, title: tip }, [
    text,
    input.element,
    why,
  ]);
  for (const control of input.inputs) {
    control.setAttribute("aria-describedby", `${id}-why`);
    control.setAttribute("aria-description", tip);
  }
  return {
    name,
    group,
    element: row,
    update,
  };

  /** @param {FieldState} state */
  function update(state) {
    last = state;
    input.show(state);
    const problem = refused ? `“${refused}” is no number` : state.problem;
    const said = problem || state.idle;
    why.textContent = said;
    why.hidden = said === "" || (group !== "" && problem === "");
    row.title = state.idle ? `${tip} ${state.idle}` : tip;
    row.classList.toggle("swc-idle", state.idle !== "");
    row.classList.toggle("swc-wrong", problem !== "");
    row.classList.toggle("swc-changed", state.isChanged);
    for (const control of input.inputs) {
      if (control.dataset.free === undefined)
        control.disabled = state.idle !== "" || control.dataset.off === "";
    }
  }
}

/**
 * Listens to an input that can be dragged: movements are shown, the end is meant. Escape takes it back.
 * @param {HTMLInputElement} input
 * @param {() => unknown} value
 * @param {string} name
 * @param {Actions} actions
 */
function followDrag(input, value, name, actions) {
  let isMoving = false;
  let timer = 0;
  let byKey = false;
  const finish = () => {
    clearTimeout(timer);
    if (!isMoving) return;
    isMoving = false;
    if (input.value !== input.dataset.shown) actions.set(name, value());
    else actions.leave(name);
  };
  input.addEventListener("input", () => {
    isMoving = true;
    clearTimeout(timer);
    actions.move(name, value());
    if (byKey) timer = window.setTimeout(finish, KEY_MS);
  });
  input.addEventListener("change", () => byKey || finish());
  input.addEventListener("pointerdown", () => {
    byKey = false;
  });
  for (const event of ["pointerup", "pointercancel"]) {
    input.addEventListener(event, () => window.setTimeout(() => byKey || finish())); // after "change"
  }
  input.addEventListener("blur", finish);
  input.addEventListener("keydown", (event) => {
    byKey = true;
    event.stopPropagation(); // the host's shortcuts
    if (event.key !== "Escape" || !isMoving) return;
    isMoving = false;
    clearTimeout(timer);
    actions.leave(name);
  });
  return () => isMoving;
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function slider({ name, label, low = 0, high = 1, step = 1, automatic, automaticValue, kind }, actions, id) {
  const track = element("input", { type: "range", id, min: `${low}`, max: `${high}`, step: `${step}` });
  const typed = () => numberOf(exact.value);
  const exact = createNumberInput({ step }, { "aria-label": `${label}, exactly` }, () =>
    actions.set(name, typed()),
  );
  const box = automatic
    ? checkbox(automatic, kind === "family" ? `${label}, as computed` : `${label}, ${automatic}`)
    : null;
  const inputs = box ? [track, exact, box.input] : [track, exact];
  if (box) box.input.dataset.free = "";
  const isMoving = followDrag(track, () => Number(track.value), name, actions);
  track.addEventListener("input", () => {
    exact.value = track.value;
    if (box && kind === "family") box.input.checked = false;
    paint(track);
  });
  const isTyping = commit(exact, typed, name, actions);
  box?.input.addEventListener("change", () =>
    actions.set(name, box.input.checked ? automaticValue : Number(track.value)),
  );
  return {
    element: element("div", { class: "swc-input" }, [track, exact, ...(box ? [box.label] : [])]),
    inputs,
    show({ value, family }) {
      const isAutomatic = Boolean(box) && value === automaticValue;
      const number = isAutomatic && family?.length ? family[2] : value;
      if (box) box.input.checked = isAutomatic;
      const isOff = isAutomatic && kind !== "family";
      for (const control of [track, exact]) {
        if (isOff) control.dataset.off = "";
        else delete control.dataset.off;
      }
      if (isMoving() || isTyping()) return;
      if (family?.length) [track.min, track.max] = [String(family[0]), String(family[1])];
      else if (typeof number === "number") {
        track.max = String(Math.max(high, number));
        track.min = String(Math.min(low, number));
      }
      if (typeof number === "number") {
        track.value = exact.value = String(number);
        track.setAttribute("aria-valuetext", String(number));
      }
      track.dataset.shown = track.value;
      paint(track);
    },
  };
}

/** The part of a track left of its thumb is coloured. @param {HTMLInputElement} track */
function paint(track) {
  const [low, high] = [Number(track.min), Number(track.max)];
  const share = high > low ? (Number(track.value) - low) / (high - low) : 0;
  track.style.setProperty("--swc-to", `${100 * Math.min(1, Math.max(0, share))}%`);
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function range({ name, label, low = 0, high = 1, automatic = "" }, actions, id) {
  const attributes = { type: "range", min: `${low}`, max: `${high}`, step: "1" };
  const least = element("input", { ...attributes, id, "aria-label": `${label}, least` });
  const most = element("input", { ...attributes, "aria-label": `${label}, most` });
  const shown = element("output", { class: "swc-output", for: id });
  const tied = checkbox(automatic, `${label}, ${automatic}`);
  tied.input.dataset.tied = "";
  const value = () => {
    const ends = [Number(least.value), Number(most.value)];
    return [Math.min(...ends), Math.max(...ends)];
  };
  const say = () => {
    const [from, to] = value();
    shown.textContent = `${from} – ${to}`;
    const [a, b] = [Number(least.min), Number(least.max)];
    pair.style.setProperty("--swc-from", `${(100 * (from - a)) / (b - a)}%`);
    pair.style.setProperty("--swc-to", `${(100 * (to - a)) / (b - a)}%`);
  };
  const movings = [least, most].map((input) => {
    const isMoving = followDrag(input, value, name, actions);
    input.addEventListener("input", () => {
      tied.input.checked = false;
      say();
    });
    return isMoving;
  });
  tied.input.addEventListener("change", () => actions.set(name, tied.input.checked ? null : value()));
  const pair = element("div", { class: "swc-pair" }, [least, most]);
  return {
    element: element("div", { class: "swc-input" }, [pair, shown, tied.label]),
    inputs: [least, most, tied.input],
    show({ value: given, bounds }) {
      if (movings.some((isMoving) => isMoving())) return;
      const [from, to] = given ?? bounds ?? [low, high];
      for (const input of [least, most]) {
        input.min = String(Math.min(low, from));
        input.max = String(Math.max(high, to));
      }
      least.value = least.dataset.shown = String(from);
      most.value = most.dataset.shown = String(to);
      tied.input.checked = given === null;
      say();
    },
  };
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function number({ name, low, high, step }, actions, id) {
  const typed = () => numberOf(input.value);
  const input = createNumberInput({ step, low, high }, { id }, () => actions.set(name, typed()));
  const isTyping = commit(input, typed, name, actions);
  return {
    element: element("div", { class: "swc-input" }, [input]),
    inputs: [input],
    show: shower(input, String, isTyping),
  };
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function list({ name }, actions, id) {
  const input = element("input", { type: "text", id, inputmode: "decimal" });
  const value = () => numbersOf(input.value);
  const isTyping = commit(input, value, name, actions);
  return {
    element: element("div", { class: "swc-input" }, [input]),
    inputs: [input],
    show: shower(input, (numbers) => numbers.join(", "), isTyping),
  };
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function choice({ name, choices = [] }, actions, id) {
  const options = choices.map(([value, text, why]) =>
    why
      ? element("option", { value, disabled: "" }, [`${text}: ${why}`])
      : element("option", { value }, [text]),
  );
  const input = element("select", { id }, options);
  input.addEventListener("change", () => actions.set(name, input.value));
  input.addEventListener("keydown", (event) => event.stopPropagation());
  return {
    element: element("div", { class: "swc-input" }, [input]),
    inputs: [input],
    show: shower(input, String),
  };
}

/** @param {Description} d @param {Typing} actions @param {string} id @returns {Input} */
function check({ name }, actions, id) {
  const input = element("input", { type: "checkbox", id });
  input.addEventListener("change", () => actions.set(name, input.checked));
  return {
    element: element("div", { class: "swc-input" }, [input]),
    inputs: [input],
    show: ({ value }) => {
      input.checked = value;
    },
  };
}

/**
 * Numbers one after another. Commas part them, unless something else does.
 * @param {string} text
 */
export function numbersOf(text) {
  const isParted = /;|\d\s+[-+−.,]?\d/.test(text);
  return text
    .split(isParted ? /;\s*|,?\s+/ : /[,\s]+/)
    .filter(Boolean)
    .map(numberOf);
}

/**
 * What is typed counts when it is done, and comes back with Escape. What is no number stays to be mended.
 * @param {HTMLInputElement} input
 * @param {() => number | number[]} value
 * @param {string} name
 * @param {Typing} actions
 * @returns {() => boolean}  whether somebody is typing: a result that comes meanwhile leaves the input alone
 */
function commit(input, value, name, actions) {
  let isTyping = false;
  input.addEventListener("input", () => {
    isTyping = true;
  });
  input.addEventListener("change", () => {
    const given = value();
    const isNumber = !input.value.trim() || ![given].flat().some(Number.isNaN);
    isTyping = !isNumber;
    actions.refuse(isNumber ? "" : input.value.trim());
    if (!isNumber) return;
    if (input.value.trim() === "") actions.leave(name);
    else actions.set(name, given);
  });
  const leave = () => {
    isTyping = false;
    actions.refuse("");
    actions.leave(name);
  };
  input.addEventListener("blur", () => isTyping && ![value()].flat().some(Number.isNaN) && leave()); // the same as it was
  input.addEventListener("keydown", (event) => {
    event.stopPropagation();
    if (event.key === "Escape") leave();
  });
  return () => isTyping;
}

/**
 * @param {HTMLInputElement | HTMLSelectElement} input
 * @param {(value: any) => string} text
 * @param {() => boolean} [isTyping]
 */
function shower(input, text, isTyping = () => false) {
  return (/** @type {FieldState} */ { value }) => {
    if (!isTyping()) input.value = text(value);
  };
}

/** @param {string} text @param {string} name */
function checkbox(text, name) {
  const input = element("input", { type: "checkbox", "aria-label": name });
  return { input, label: element("label", { class: "swc-box" }, [input, text]) };
}
