/** What is shown follows the model: the picture and the page around it take what has changed. */

import { faceValues } from "../labels/face_values.js";
import { readMesh } from "../scene/mesh.js";
import { awaitMesh } from "../scene/shared_meshes.js";
import { listen } from "../wire/listen.js";
import { GROUPS } from "../wire/traits.js";
import { boxLines } from "./boxes.js";
import { ASIDE, CUT_OFF, GONE, lostEdits, UP } from "./notices.js";
import { panelState } from "./state.js";

const LEAST_TO_ASK = 320; // pixels of a picture that has room for a question

/** @typedef {keyof typeof GROUPS} Group */

/**
 * @param {import("../input/messages.js").Around & {
 *   panel: ReturnType<typeof import("./panel.js").createPanel>,
 *   hand: import("../input/hand.js").Hand,
 *   looks: ReturnType<typeof import("../scene/kept_looks.js").createKeptLooks>,
 *   connection: import("../wire/connection.js").Connection,
 *   context: { isAside: () => boolean },
 *   measure: () => void,
 * }} around  measure: gives the picture its size
 * @returns {() => void}  take everything
 */
export function createRefresh(around) {
  const { model, view, segments, root, panel, hand, looks, connection, context, measure, on, send, signal } =
    around;
  /** Face that is pointed at. @type {number | null} */
  let pointed = null;
  const showBoxes = () => send({ kind: "boxes", boxes: boxLines(around, pointed) });
  /** Values of the faces as they are drawn. @type {ReturnType<typeof faceValues>} */
  let drawn = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let lostTimer;

  /** Take what has changed; the state always. @param {Set<Group>} groups */
  function take(groups) {
    if (groups.has("geometry")) takeMesh();
    if (groups.has("partition")) takeSegments();
    takeValues();
    takeState();
    showBoxes();
  }

  function takeMesh() {
    const mesh = readMesh(model);
    if (!mesh || mesh === view.mesh) return;
    view.setMesh(mesh);
    measure();
  }

  function takeSegments() {
    segments.read();
    if (!segments.isPreview) looks.keepHidden();
    hand.renew();
  }

  function takeValues() {
    const wanted = faceValues(model);
    if (!wanted || (wanted.values === drawn?.values && wanted.colormap === drawn.colormap)) return;
    drawn = wanted;
    view.setValues(wanted.values, wanted.colormap);
  }

  function takeState() {
    const isLive = connection.isLive();
    root.style.height = `${model.get("height")}px`;
    root.dataset.segments = String(segments.count);
    root.dataset.live = String(isLive);
    if (!isLive && model.get("mode") === "edit") model.set("mode", "navigate");
    panel.showPreview(segments);
    if (root.dataset.mode !== model.get("mode")) {
      root.dataset.mode = model.get("mode");
      hand.letGo();
    }
    view.setLook({
      colorBy: model.get("color_by"),
      mixing: model.get("color_mix"),
      outlines: model.get("outlines"),
      backFaces: model.get("back_faces"),
    });
    view.setSection(model.get("section"));
    panel.update(panelState(around, { tool: hand.tool, isLive, notices: notices(isLive) }));
    panel.listSegments(around);
  }

  /** @param {boolean} isLive */
  function notices(isLive) {
    const { notices: lost, wait } = lostEdits(segments.pending, isLive);
    clearTimeout(lostTimer);
    if (wait !== null) lostTimer = setTimeout(takeState, wait);
    const why = connection.isCutOff() ? CUT_OFF : GONE;
    const gone = isLive || lost.length > 0 ? [] : [why]; // one bar says that the kernel is gone
    const isRoomy = model.get("height") >= LEAST_TO_ASK;
    const question = isLive && isRoomy && model.get("_asks_up") ? [UP] : [];
    return [...gone, ...(context.isAside() ? [ASIDE] : []), ...lost, ...question];
  }

  const takeSome = (/** @type {Group[]} */ ...groups) => take(new Set(groups));
  on({
    segments: () => takeSome("partition"),
    state: () => takeSome(),
    tool_taken: () => takeSome(),
    hidden() {
      if (!segments.isPreview) looks.keepHidden();
      takeSome();
    },
    moving: showBoxes,
    rested() {
      looks.keepCamera();
      showBoxes();
    },
    pointed({ face }) {
      pointed = face;
      if (model.get("boxes")) showBoxes();
    },
  });
  listen(model, GROUPS, take, signal);
  awaitMesh(model, () => takeSome("geometry", "partition"), signal);
  const onPending = () => takeSome("partition");
  segments.pending.watchers.add(onPending);
  signal.addEventListener("abort", () => {
    segments.pending.watchers.delete(onPending);
    clearTimeout(lostTimer);
  });
  return () => takeSome("geometry", "partition", "values");
}
