/** Below the settings: presets, reset, the settings as code; above them: how the segments compare with the truth. */

import { element, textButton } from "../panel/elements.js";

/**
 * @typedef {object} BarState
 * @property {string} preset
 * @property {string[]} presets
 * @property {number} nChanged  settings that differ from the preset
 * @property {string} code
 * @property {boolean} canRerun
 * @property {boolean} canSuggest
 * @property {Array<{ name: string, text: string, tip: string, trend: "" | "better" | "worse" }>} scores
 */

const COPIED_MS = 2500;

/** @param {{ send: (message: Record<string, unknown>) => void, suggest: (what: "next" | "names") => void }} actions */
export function createBar(actions) {
  const { send } = actions;
  const preset = element("select", {
    class: "swc-preset",
    "aria-label": "Preset",
    title: "Start from these settings",
  });
  const reset = textButton("Reset to preset", "Take all changes back");
  const copy = textButton("Copy as code", "Copy these settings as Python");
  const rerun = textButton("Segment again", "Compute with the settings shown, after a cancel or an error");
  const suggest = textButton("Next suggestion", "Show the edit most worth looking at (K in the picture)");
  const names = textButton("Name what shapes tell", "Name floor, walls and the like that have no name yet");
  rerun.classList.add("swc-rerun");
  const note = element("span", { class: "swc-note", role: "status" });
  const bar = element("div", { class: "swc-bar" }, [
    element("label", { class: "swc-field" }, ["Preset", preset]),
    ...[reset, copy, suggest, names, note, rerun],
  ]);
  const scores = element("div", {
    class: "swc-scores",
    role: "group",
    "aria-label": "Against the truth",
    hidden: "",
  });
  let code = "";
  let timer = 0;
  preset.onchange = () => send({ kind: "preset", name: preset.value });
  reset.onclick = () => send({ kind: "preset", name: preset.value });
  suggest.onclick = () => actions.suggest("next");
  names.onclick = () => actions.suggest("names");
  rerun.onclick = () => send({ kind: "rerun" });
  copy.onclick = async () => {
    const isCopied = await copyText(code);
    note.textContent = isCopied ? `Copied: ${code}` : code;
    clearTimeout(timer);
    if (isCopied) timer = window.setTimeout(() => note.replaceChildren(), COPIED_MS);
  };
  return {
    element: bar,
    scores,
    /** @param {BarState} state */
    update(state) {
      code = state.code;
      suggest.hidden = names.hidden = !state.canSuggest;
      if (preset.options.length !== state.presets.length) {
        preset.replaceChildren(...state.presets.map((name) => element("option", { value: name }, [name])));
      }
      preset.value = state.preset;
      reset.disabled = state.nChanged === 0;
      copy.title = `Copy these settings as Python: ${code}`;
      rerun.hidden = !state.canRerun;
      scores.hidden = state.scores.length === 0;
      scores.replaceChildren(
        element("span", { class: "swc-scores-title" }, ["Against the truth"]),
        ...state.scores.map(({ name, text, tip, trend }) =>
          element("span", { class: "swc-score", title: tip, "data-score": name, "data-trend": trend }, [
            element("span", { class: "swc-score-name" }, [name]),
            element("b", {}, [text]),
            ...(trend
              ? [
                  element("span", { class: "swc-trend", "aria-label": trend }, [
                    trend === "better" ? "▲" : "▼",
                  ]),
                ]
              : []),
          ]),
        ),
      );
    },
  };
}

/** @param {string} text @returns {Promise<boolean>} */
async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = element("textarea", { style: "position:fixed;opacity:0" });
    area.value = text;
    document.body.append(area);
    area.select();
    const isCopied = document.execCommand("copy");
    area.remove();
    return isCopied;
  }
}
