/** The view of a scan on a page: makes its parts, which speak through one dispatcher. */

import { createAim } from "./input/aim.js";
import { createCameraCommands } from "./input/camera_commands.js";
import { createCutPreview } from "./input/cut_preview.js";
import { createEditCommands } from "./input/edit_commands.js";
import { createHand } from "./input/hand.js";
import { listenToKeys } from "./input/keyboard.js";
import { createLinkedViews } from "./input/linked_views.js";
import { listenToPointer } from "./input/pointer.js";
import { createRefine } from "./input/refine.js";
import { createStateCommands } from "./input/state_commands.js";
import { listenToWheel } from "./input/wheel.js";
import { Preview } from "./labels/preview.js";
import { ShownSegments } from "./labels/shown_segments.js";
import { ASIDE } from "./panel/notices.js";
import { createPanel } from "./panel/panel.js";
import { createRefresh } from "./panel/refresh.js";
import { relayRemarks } from "./panel/remarks.js";
import { createSuggestionBar } from "./panel/suggestion_bar.js";
import { showTheme } from "./panel/theme.js";
import { watchContext } from "./scene/context_watch.js";
import { createKeptLooks } from "./scene/kept_looks.js";
import { Viewer } from "./scene/viewer.js";
import { watchConnection } from "./wire/connection.js";
import { createDispatcher } from "./wire/dispatcher.js";

/** @typedef {import("./wire/wire.js").Model} Model */
/** @typedef {ReturnType<typeof createDispatcher<import("./input/messages.js").Message>>} Dispatcher */

/**
 * What one page alone knows of a view, for the one that takes its place.
 * @typedef {object} Kept
 * @property {import("./scene/camera.js").Camera} [camera]
 * @property {import("./scene/camera.js").Camera | null} [outside]
 * @property {import("./input/gestures.js").Tool} [tool]
 * @property {boolean} [isSectionShown]
 */

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @returns {() => void}  undoes everything
 */
function render(host) {
  let view = start(host, again, {});
  function again() {
    const kept = view.keep();
    view.stop();
    view = start(host, again, kept);
  }
  return () => view.stop();
}

/**
 * @param {{ model: Model, el: HTMLElement }} host
 * @param {() => void} again  ends this view and makes another in its place
 * @param {Kept} kept  of the view before
 * @returns {{ stop: () => void, keep: () => Kept }}  stop undoes everything
 */
function start({ model, el }, again, kept) {
  const life = new AbortController();
  const { signal } = life;
  const { on, send } = /** @type {Dispatcher} */ (createDispatcher());
  const panel = createPanel(el, { on, send });
  const { root, canvas } = panel;
  /** @type {Viewer} */
  let view;
  try {
    view = new Viewer(canvas, {
      onFirstFrame: () => setReady(true),
      onFailure: (error) => panel.showFailure(`The 3D view has stopped: ${messageOf(error)}`),
      onMove: () => send({ kind: "moving" }),
      onCamera: (camera) => send({ kind: "moved", camera }),
      onRest: () => send({ kind: "rested" }),
    });
  } catch (error) {
    panel.showFailure(
      `The 3D view can't be drawn: ${messageOf(error)} It needs WebGL 2, which ` +
        "current browsers have; on a remote or virtual machine it may have to be switched on.",
    );
    return { stop: () => root.remove(), keep: () => kept };
  }
  const camera = kept.camera ?? model.get("_camera");
  if (camera?.target) view.first = camera;
  view.outside = kept.outside ?? null;

  const preview = new Preview(model, () => send({ kind: "segments" }), signal);
  const segments = new ShownSegments(model, preview, view);
  const around = { model, view, segments, root, canvas, on, send, signal };

  // what people want and do ----------------------------------------------------------------------------
  createStateCommands(around);
  const hand = createHand(around);
  const aim = createAim({ ...around, hand, cutPreview: createCutPreview(around) });
  createLinkedViews(around);
  createRefine({ ...around, picked: hand.picked });
  createEditCommands({ ...around, target: aim.target });
  const { strides } = createCameraCommands(around);
  listenToPointer({ ...around, hand, aim });
  listenToWheel(around);
  const connection = watchConnection(model, el, () => send({ kind: "state" }), signal);
  createSuggestionBar({ ...around, connection }, panel.dock); // hears keys before the keyboard does
  const closing = [panel.closeHelp, hand.back, panel.closeSection, panel.closePicture, panel.closeHistory];
  listenToKeys({ ...around, aim, strides, closing });

  // what is there to be shown ---------------------------------------------------------------------------
  const context = watchContext(canvas, { send, again }, signal);
  const looks = createKeptLooks({ model, view, send });
  const measure = () => view.resize(canvas.clientWidth, canvas.clientHeight);
  const takeAll = createRefresh({ ...around, panel, hand, looks, connection, context, measure });
  relayRemarks(around);
  on({
    moving() {
      root.dataset.moving = "true";
      panel.showInside(view.isInside);
    },
    rested() {
      root.dataset.moving = "false";
    },
    lost() {
      view.lose();
      send({ kind: "let_go" });
      setReady(false);
    },
    restored() {
      send({ kind: "state" });
      view.restore();
      setReady(true);
    },
    answer({ notice, action }) {
      if (notice === ASIDE.key) again();
      else if (action === "forget") segments.pending.forget();
      else model.send({ kind: "choose", notice, action });
    },
  });
  function setReady(/** @type {boolean} */ isReady) {
    root.dataset.ready = String(isReady);
  }

  showTheme(around);
  const observer = new ResizeObserver(measure);
  observer.observe(canvas);
  signal.addEventListener("abort", () => observer.disconnect());

  takeAll();
  if (kept.tool) hand.setTool(kept.tool);
  if (kept.isSectionShown) panel.section.show(true, { isFocused: false });

  return {
    stop: () => {
      life.abort();
      view.dispose();
      root.remove();
    },
    keep: () => ({
      camera: view.camera,
      outside: view.outside,
      tool: hand.tool,
      isSectionShown: panel.section.isShown(),
    }),
  };
}

/** @param {unknown} error */
function messageOf(error) {
  return error instanceof Error ? error.message : String(error);
}

export { savedModel } from "./wire/saved_model.js";
export default { render };
