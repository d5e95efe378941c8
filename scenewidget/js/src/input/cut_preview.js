/**
 * What a cut between two points would divide off: asked of Python while the pointer rests, shown as if it were done.
 *
 * Only the newest pair of points counts. One question is under way at a time, so a slow answer holds up the
 * cut itself by no more than that.
 */

import { facesOf } from "../labels/offcut.js";
import { on } from "../wire/listen.js";
import { asBytes } from "../wire/wire.js";

const REST_MS = 120;

/** @typedef {{ face_a: number, face_b: number }} Pair  the second one is on the side that is cut off */

/** @param {Pick<import("./messages.js").Around, "model" | "segments" | "send" | "signal">} around */
export function createCutPreview({ model, segments, send, signal }) {
  const me = Math.random().toString(36).slice(2, 8);
  let n = 0;
  /** @type {Pair | null} */
  let wanted = null;
  /** Segments of the atoms that the pair is wanted for. @type {Uint32Array | null} */
  let under = null;
  /** @type {{ request: string, pair: Pair, under: Uint32Array | null } | null} */
  let asked = null;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;

  /** @param {number[]} faces */
  function show(faces) {
    if (faces.length === 0 && segments.offcut === null) return;
    segments.cutOff(faces);
    send({ kind: "segments" });
  }

  function ask() {
    if (!wanted || asked || segments.pending.operations.length > 0) return;
    asked = { request: `${me}${++n}`, pair: wanted, under };
    model.send({
      ...{ kind: "preview_cut", request: asked.request, ...wanted },
      revision: model.get("revision"),
    });
    send({ kind: "cut_sought" });
  }

  const onMessage = (/** @type {any} */ message, /** @type {any[]} */ buffers) => {
    if (message?.kind !== "cut_preview" || !asked || message.request !== asked.request) return;
    const { pair, under: before } = asked;
    asked = null;
    const isOf = pair.face_a === wanted?.face_a && before === segments.atomSegment;
    if (isOf) show(facesOf(message.first, asBytes(buffers[0])));
    if (!isSame(pair, wanted)) ask();
    if (!asked) send({ kind: "cut_sought" });
  };
  on(model, "msg:custom", onMessage, signal);
  signal.addEventListener("abort", () => clearTimeout(timer));

  return {
    /** Whether Python is looking for a cut that is still wanted. */
    get isLooking() {
      return asked !== null && wanted !== null;
    },

    /**
     * These are the points of the cut now; the second is null while it is nowhere, both if there is no cut.
     * @param {number | null} first  face
     * @param {number | null} second
     */
    aim(first, second) {
      if (segments.pending.operations.some(({ kind }) => kind === "cut")) return; // shown until it is done
      const isPair = first !== null && second !== null && segments.canCut(first, second);
      const next = isPair ? { face_a: first, face_b: second } : null;
      if (isSame(next, wanted) && under === segments.atomSegment && first !== null) return;
      [wanted, under] = [next, segments.atomSegment];
      clearTimeout(timer);
      if (first === null) show([]);
      else timer = setTimeout(wanted ? ask : () => show([]), REST_MS);
    },
  };
}

/** @param {Pair | null} a @param {Pair | null} b */
function isSame(a, b) {
  return a?.face_a === b?.face_a && a?.face_b === b?.face_b;
}
